#include "render/program.h"

#include "render/renderer.h"
#include "render/shaders.h"

#include <regex>

namespace firn {

void delete_program(GLuint id) { glDeleteProgram(id); }

namespace {

void delete_shader(GLuint id) { glDeleteShader(id); }
using Shader = GLObject<delete_shader>;

std::string joined_names(const std::vector<std::string>& files) {
    std::string names;
    for (const std::string& file : files) names += (names.empty() ? "" : " + ") + file;
    return names;
}

constexpr unsigned lines_per_file = 10000;

/// Messages begin with a file, which Mesa always takes for 0, and a line: 0:20023(4) or 0(20023). With the file's
/// name, and the line in it, instead.
std::string with_names(const std::string& log, const std::vector<std::string>& files) {
    static const std::regex place(R"((^|\n)(ERROR: |WARNING: )?\d+[:(](\d{1,6}))");
    std::string named;
    auto rest = log.begin();
    for (std::sregex_iterator match(log.begin(), log.end(), place), end; match != end; ++match) {
        const unsigned long line = std::stoul((*match)[3].str()), file = line / lines_per_file;
        named.append(rest, (*match)[1].second);
        named += (file == 0 || file > files.size() ? "common.glsl" : files[file - 1]) + ":" +
                 std::to_string(line % lines_per_file);
        rest = (*match)[3].second;
    }
    return named.append(rest, log.end());
}

Shader compile(GLenum stage, const std::vector<std::string>& files,
               const std::map<std::string, int>& constants) {
    const auto sources = shader_sources();
    std::string text = "#version 330 core\n";
    for (const auto& [name, value] : constants)
        text += "const int " + name + " = " + std::to_string(value) + ";\n";
    text += "#line 1\n" + sources.at("common.glsl");
    for (std::size_t i = 0; i < files.size(); ++i)
        text += "\n#line " + std::to_string(lines_per_file * (i + 1) + 1) + "\n" + sources.at(files[i]);
    Shader shader(glCreateShader(stage));
    const char* pointer = text.c_str();
    glShaderSource(shader.id(), 1, &pointer, nullptr);
    glCompileShader(shader.id());
    GLint good = 0;
    glGetShaderiv(shader.id(), GL_COMPILE_STATUS, &good);
    if (!good) {
        char log[4096] = "";
        glGetShaderInfoLog(shader.id(), sizeof log, nullptr, log);
        throw GLError("shader common.glsl + " + joined_names(files) + " does not compile:\n" +
                      with_names(log, files));
    }
    return shader;
}

}  // namespace

Program::Program(const std::vector<std::string>& vertex_files, const std::vector<std::string>& fragment_files,
                 const std::map<std::string, int>& constants)
    : name_(joined_names(vertex_files) + " and " + joined_names(fragment_files)),
      program_(glCreateProgram()) {
    const Shader vertex = compile(GL_VERTEX_SHADER, vertex_files, constants);
    const Shader fragment = compile(GL_FRAGMENT_SHADER, fragment_files, constants);
    glAttachShader(program_.id(), vertex.id());
    glAttachShader(program_.id(), fragment.id());
    glLinkProgram(program_.id());
    GLint good = 0;
    glGetProgramiv(program_.id(), GL_LINK_STATUS, &good);
    if (!good) {
        char log[4096] = "";
        glGetProgramInfoLog(program_.id(), sizeof log, nullptr, log);
        throw GLError("shaders " + name_ + " do not link:\n" + log);
    }
    GLint count = 0;
    glGetProgramiv(program_.id(), GL_ACTIVE_UNIFORMS, &count);
    for (GLint i = 0; i < count; ++i) {
        char name[256] = "";
        GLint size = 0;
        GLenum type = 0;
        glGetActiveUniform(program_.id(), static_cast<GLuint>(i), sizeof name, nullptr, &size, &type, name);
        unset_.insert(name);
    }
}

void Program::use() const {
    if (used_ && !unset_.empty())
        throw GLError("uniform " + *unset_.begin() + " of shaders " + name_ + " has never been set");
    used_ = true;
    glUseProgram(program_.id());
}

GLint Program::location(const char* name) const {
    unset_.erase(name);
    return glGetUniformLocation(program_.id(), name);
}

void Program::set(const char* name, int x) const { glUniform1i(location(name), x); }
void Program::set(const char* name, float x) const { glUniform1f(location(name), x); }
void Program::set(const char* name, const Eigen::Vector2f& x) const {
    glUniform2fv(location(name), 1, x.data());
}
void Program::set(const char* name, const Eigen::Vector3f& x) const {
    glUniform3fv(location(name), 1, x.data());
}
void Program::set(const char* name, const Eigen::Vector4f& x) const {
    glUniform4fv(location(name), 1, x.data());
}
void Program::set(const char* name, const std::vector<Eigen::Vector4f>& x) const {
    const GLint there = location(name);
    if (!x.empty()) glUniform4fv(there, static_cast<GLsizei>(x.size()), x.front().data());
}
void Program::set(const char* name, const Eigen::Matrix3f& x) const {
    glUniformMatrix3fv(location(name), 1, GL_FALSE, x.data());
}
void Program::set(const char* name, const Eigen::Matrix4f& x) const {
    glUniformMatrix4fv(location(name), 1, GL_FALSE, x.data());
}

}  // namespace firn
