#include "app/scene_json.h"
#include "app/scene_keys.h"

#include <fmt/format.h>

#include <cmath>
#include <type_traits>

namespace firn {

using Json = nlohmann::ordered_json;

// In presets no key is required, and a list can be changed by entries named by their index.
enum class Form { whole, changes };

static Json reference(const std::string& name) { return {{"$ref", "#/definitions/" + name}}; }

static std::string definition(ShapeUse use, Form form) {
    const std::string name = use == ShapeUse::solid ? "solid"
                             : use == ShapeUse::cut ? "cut"
                                                    : "collider_shape";
    return form == Form::whole ? name : name + "_change";
}

static Json with_range(Json schema, const Range& range) {
    if (std::isfinite(range.lower)) schema[range.above_lower ? "exclusiveMinimum" : "minimum"] = range.lower;
    if (std::isfinite(range.upper)) schema[range.below_upper ? "exclusiveMaximum" : "maximum"] = range.upper;
    return schema;
}

static Json vector_schema(const Range& range) {
    return {{"type", "array"},
            {"items", with_range({{"type", "number"}}, range)},
            {"minItems", 3},
            {"maxItems", 3}};
}

// A list, or in a preset also some of its entries by index.
static Json list_schema(const Json& item, const Json& change, bool required, Form form) {
    Json list{{"type", "array"}, {"items", item}};
    if (required) list["minItems"] = 1;
    if (form == Form::whole) return list;
    const Json by_index{{"type", "object"}, {"patternProperties", {{"^[0-9]+(\\..+)?$", change}}},
                        {"additionalProperties", false}};
    return {{"anyOf", {list, by_index}}};
}

template <class T> static Json object_schema(Form form);

// Collects the schema of an object's keys.
struct SchemaWriter {
    Form form;
    Json properties = Json::object();
    Json required = Json::array();
    Json one_of = nullptr, not_both = nullptr;

    template <class T, class... Use> void key(const Key& k, T& member, Use... use) {
        Json schema = schema_of(k, member, use...);
        std::string help = k.help;
        if (*k.unit) help += fmt::format(" [{}]", k.unit);
        if (schema.contains("$ref"))
            schema = {{"allOf", {schema}}};  // draft 7 ignores what stands beside a $ref
        schema["description"] = help;
        properties[k.name] = schema;
        if (k.required && form == Form::whole) required.push_back(k.name);
    }

    void either(const Key& a, Shape& shape, const Key& b, std::string& file) {
        key(a, shape, ShapeUse::solid);
        key(b, file);
        one_of = {{{"required", {a.name}}}, {{"required", {b.name}}}};
    }

    void either(const Key& a, double& first, const Key& b, std::optional<double>&) {
        key(a, first);
        properties[b.name] = with_range({{"type", "number"}, {"description", b.help}}, b.range);
        not_both = {{"required", {a.name, b.name}}};
    }

    Json schema_of(const Key& k, double& v) {
        return with_default(with_range({{"type", "number"}}, k.range), k, v);
    }
    template <class T> requires(std::is_integral_v<T> && !std::is_same_v<T, bool>) Json schema_of(const Key& k, T& v) {
        return with_default(with_range({{"type", "integer"}}, k.range), k, v);
    }
    Json schema_of(const Key& k, bool& v) { return with_default({{"type", "boolean"}}, k, v); }
    Json schema_of(const Key& k, std::optional<double>& v) {
        return {{"anyOf", {{{"const", "auto"}}, with_range({{"type", "number"}}, k.range)}},
                {"default", v ? Json(*v) : Json("auto")}};
    }
    Json schema_of(const Key& k, Vec3d& v) {
        return with_default(vector_schema(k.range), k, Json{v[0], v[1], v[2]});
    }
    Json schema_of(const Key&, std::string&) {
        return {{"type", "string"}, {"minLength", 1}, {"maxLength", 1000}};
    }
    template <class E> requires std::is_enum_v<E> Json schema_of(const Key& k, E& v) {
        Json names = Json::array();
        for (const auto& choice : choices(v)) names.push_back(choice.name);
        return with_default({{"enum", names}}, k, name_of(v));
    }
    Json schema_of(const Key&, Shape&, ShapeUse use) { return reference(definition(use, form)); }
    template <class T>
    requires std::is_class_v<T> Json schema_of(const Key&, T&) { return object_schema<T>(form); }
    template <class T> Json schema_of(const Key&, std::optional<T>&) { return object_schema<T>(form); }
    template <class T> Json schema_of(const Key&, std::map<std::string, T>&) {
        return {{"type", "object"}, {"propertyNames", {{"pattern", "^[A-Za-z0-9_-]{1,64}" + tail()}}},
                {"additionalProperties", object_schema<T>(form)}, {"maxProperties", 256}};
    }
    template <class T> Json schema_of(const Key& k, std::vector<T>&) {
        return list_schema(object_schema<T>(Form::whole), object_schema<T>(Form::changes), k.required, form);
    }

    std::string tail() const { return form == Form::whole ? "$" : ""; }

    Json with_default(Json schema, const Key& k, const Json& value) const {
        if (!k.required && form == Form::whole) schema["default"] = value;
        return schema;
    }
};

template <class T> static Json object_schema(Form form) {
    T object;
    SchemaWriter writer{form};
    describe(writer, object);
    Json schema{{"type", "object"}, {"properties", writer.properties}, {"additionalProperties", false}};
    if (form == Form::changes) schema["patternProperties"] = {{"\\.", Json::object()}};  // dotted paths
    if (!writer.required.empty()) schema["required"] = writer.required;
    if (form == Form::whole && !writer.one_of.is_null()) schema["oneOf"] = writer.one_of;
    if (!writer.not_both.is_null()) schema["not"] = writer.not_both;
    return schema;
}

// Collects the schemas of the kinds of shapes that may stand in one place.
struct KindSchemas {
    ShapeUse use;
    Form form;
    Json properties = Json::object();

    template <class Kind> void kind(const char* name, const char* help, Kind) {
        if constexpr (std::is_same_v<Kind, Union> || std::is_same_v<Kind, Difference>) {
            const bool cuts = std::is_same_v<Kind, Difference>;
            const Json first = reference(definition(use, Form::whole));
            Json list = list_schema(first, reference(definition(use, Form::changes)), true, form);
            if (cuts && form == Form::whole)
                list = {{"type", "array"}, {"items", Json::array({first})}, {"minItems", 1},
                        {"additionalItems", reference(definition(ShapeUse::cut, Form::whole))}};
            if (cuts && form == Form::changes) list = {{"type", {"array", "object"}}};
            properties[name] = list;
        } else {
            properties[name] = object_schema<Kind>(form);
        }
        properties[name]["description"] = help;
    }
};

static Json shape_schema(ShapeUse use, Form form) {
    KindSchemas kinds{use, form};
    describe_kinds(kinds, use);
    Json schema{{"type", "object"}, {"properties", kinds.properties}, {"additionalProperties", false}};
    if (form == Form::changes) schema["patternProperties"] = {{"\\.", Json::object()}};
    else schema["minProperties"] = 1;
    schema["maxProperties"] = 1;
    return schema;
}

Json scene_schema() {
    Json schema{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "firn scene"}};
    schema.update(object_schema<Scene>(Form::whole));
    const Json preset = reference("changes");
    schema["properties"]["presets"] = {
        {"type", "object"},
        {"description", "named sets of keys that --preset NAME puts over the scene"},
        {"properties", {{"draft", preset}, {"preview", preset}, {"final", preset}}},
        {"additionalProperties", false}};
    schema["definitions"]["changes"] = object_schema<Scene>(Form::changes);
    for (const auto use : {ShapeUse::solid, ShapeUse::cut, ShapeUse::collider})
        for (const auto form : {Form::whole, Form::changes})
            schema["definitions"][definition(use, form)] = shape_schema(use, form);
    return schema;
}

}  // namespace firn
