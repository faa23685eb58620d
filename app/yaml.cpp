#include "app/yaml.h"

#include "app/utf8.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <numeric>
#include <sstream>
#include <unordered_map>

namespace firn {

constexpr std::size_t max_depth = 64, max_values = 100'000;

const Yaml* Yaml::find(const std::string& key) const {
    const auto found = std::find_if(entries.begin(), entries.end(), [&](auto& e) { return e.key == key; });
    return found == entries.end() ? nullptr : &found->value;
}

Yaml* Yaml::find(const std::string& key) { return const_cast<Yaml*>(std::as_const(*this).find(key)); }

static std::size_t count(const Yaml& value) {
    std::size_t n = 1;
    for (const auto& item : value.items) n += count(item);
    for (const auto& entry : value.entries) n += count(entry.value);
    return n;
}

// The positions of a text: yaml-cpp counts bytes, people count characters.
class Positions {
public:
    Positions(const std::string& text, std::shared_ptr<const Source> source, int first_column)
        : text_(text), source_(std::move(source)), first_column_(first_column), characters_(text.size() + 1) {
        for (std::size_t i = 0; i < text.size(); ++i)
            characters_[i + 1] = characters_[i] + ((static_cast<unsigned char>(text[i]) & 0xC0) != 0x80);
    }

    Place at(const YAML::Mark& mark) const {
        const std::size_t byte = std::min<std::size_t>(std::max(mark.pos, 0), text_.size());
        const std::size_t line_start = byte - std::min<std::size_t>(std::max(mark.column, 0), byte);
        const int column = static_cast<int>(characters_[byte] - characters_[line_start]);
        return {source_, std::max(mark.line, 0) + 1, column + (mark.line <= 0 ? first_column_ : 1)};
    }

    // yaml-cpp takes the end of the file for a closing quote.
    bool closes_quote(const YAML::Mark& mark) const {
        std::size_t i = static_cast<std::size_t>(std::max(mark.pos, 0));
        while (i < text_.size() && text_[i] == '&')  // the value's anchor stands first
            i = text_.find_first_not_of(" \t\r\n", std::min(text_.find_first_of(" \t\r\n", i), text_.size()));
        if (i >= text_.size() || (text_[i] != '"' && text_[i] != '\'')) return true;
        const char quote = text_[i];
        while (++i < text_.size()) {
            if (quote == '"' && text_[i] == '\\') ++i;
            else if (text_[i] == quote && quote == '\'' && text_.compare(i, 2, "''") == 0) ++i;
            else if (text_[i] == quote) return true;
        }
        return false;
    }

private:
    const std::string& text_;
    std::shared_ptr<const Source> source_;
    int first_column_;
    std::vector<std::uint32_t> characters_;  // before each byte
};

// Builds the tree from the parser's events.
class TreeBuilder : public YAML::EventHandler {
public:
    explicit TreeBuilder(const Positions& positions) : positions_(positions) {}

    Yaml root;
    bool any = false;

    void OnDocumentStart(const YAML::Mark& mark) override {
        if (any) fail(positions_.at(mark), "", "a second document begins here; a scene is one document");
        any = true;
    }
    void OnDocumentEnd() override {}
    void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { place(start(mark, "?"), anchor); }
    void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  const std::string& text) override {
        Yaml value = start(mark, tag);
        value.kind = Yaml::Kind::scalar;
        value.text = text;
        value.quoted = tag == "!";
        if (value.quoted && !positions_.closes_quote(mark))
            fail(value.place, "", "this quote is never closed");
        if (!is_printable(text)) fail(value.place, "", "a control character in a text");
        place(std::move(value), anchor);
    }
    void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
        const auto found = anchors_.find(anchor);
        if (found == anchors_.end())
            fail(positions_.at(mark), "", "this alias stands inside what it refers to");
        Yaml value = spend(found->second);
        value.place = positions_.at(mark);
        place(std::move(value), YAML::NullAnchor);
    }
    void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                         YAML::EmitterStyle::value) override { open(mark, tag, anchor, Yaml::Kind::list); }
    void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                    YAML::EmitterStyle::value) override { open(mark, tag, anchor, Yaml::Kind::mapping); }
    void OnSequenceEnd() override { close(); }
    void OnMapEnd() override { close(); }

private:
    struct Open { Yaml value; YAML::anchor_t anchor; bool expects_value = false; };

    const Yaml& spend(const Yaml& value) {
        values_ += count(value);
        if (values_ > max_values)
            fail(value.place, "", fmt::format("more than {} values, with aliases copied", max_values));
        return value;
    }

    Yaml start(const YAML::Mark& mark, const std::string& tag) {
        Yaml value;
        value.place = positions_.at(mark);
        if (tag != "?" && tag != "!") fail(value.place, "", "tags (!...) are not supported; leave it out");
        spend(value);
        return value;
    }

    void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, Yaml::Kind kind) {
        Yaml value = start(mark, tag);
        value.kind = kind;
        if (stack_.size() >= max_depth)
            fail(value.place, "", fmt::format("nested too deeply; at most {} levels", max_depth));
        stack_.push_back({std::move(value), anchor});
    }

    void close() {
        Open done = std::move(stack_.back());
        stack_.pop_back();
        place(std::move(done.value), done.anchor);
    }

    // A finished value goes into the list or mapping that is open, as an item, a key or a key's value.
    void place(Yaml value, YAML::anchor_t anchor) {
        if (anchor != YAML::NullAnchor) anchors_[anchor] = spend(value);
        if (stack_.empty()) { root = std::move(value); return; }
        Open& parent = stack_.back();
        if (parent.value.kind == Yaml::Kind::list) { parent.value.items.push_back(std::move(value)); return; }
        if (parent.expects_value) {
            auto& entry = parent.value.entries.back();
            if (value.kind == Yaml::Kind::missing) value.place = entry.place;
            entry.value = std::move(value);
        } else {
            if (value.kind != Yaml::Kind::scalar) fail(value.place, "", "a key must be a word");
            if (value.text == "<<" && !value.quoted)
                fail(value.place, "", "merge keys (<<) are not supported; write the keys out");
            parent.value.entries.push_back({value.text, value.place, {}});
        }
        parent.expects_value = !parent.expects_value;
    }

    const Positions& positions_;
    std::vector<Open> stack_;
    std::unordered_map<YAML::anchor_t, Yaml> anchors_;
    std::size_t values_ = 0;
};

static std::string explain(const YAML::Exception& e) {
    if (e.msg.find("anchor is not defined") != std::string::npos) return "this alias refers to nothing";
    return fmt::format("not valid YAML ({}); is a colon, a quote, a bracket or the indentation wrong?",
                       e.msg);
}

Yaml parse_yaml(const std::string& input, const std::shared_ptr<const Source>& source, int first_column) {
    const std::string text = input.starts_with("\xEF\xBB\xBF") ? input.substr(3) : input;
    if (const auto fault = find_text_fault(text))
        fail({source, fault->line, fault->column + (fault->line == 1 ? first_column - 1 : 0)}, "",
             fault->message);
    const Positions positions(text, source, first_column);
    TreeBuilder builder(positions);
    try {
        std::istringstream stream(text);
        YAML::Parser parser(stream);
        while (parser.HandleNextDocument(builder)) {}
    } catch (const YAML::Exception& e) {
        fail(positions.at(e.mark), "", explain(e));
    }
    if (!builder.any) builder.root.place = {source, 1, first_column};
    return builder.root;
}

}  // namespace firn
