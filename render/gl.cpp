#include "render/gl.h"

#include "render/renderer.h"
#include "render/shaders.h"

#include <regex>

namespace firn {

void delete_buffer(GLuint id) { glDeleteBuffers(1, &id); }
void delete_vertex_array(GLuint id) { glDeleteVertexArrays(1, &id); }
void delete_texture(GLuint id) { glDeleteTextures(1, &id); }
void delete_framebuffer(GLuint id) { glDeleteFramebuffers(1, &id); }
void delete_sampler(GLuint id) { glDeleteSamplers(1, &id); }
void delete_shader(GLuint id) { glDeleteShader(id); }
void delete_program(GLuint id) { glDeleteProgram(id); }

namespace {

using Shader = GLObject<delete_shader>;

std::string error_name(GLenum code) {
    switch (code) {
        case GL_INVALID_ENUM: return "GL_INVALID_ENUM";
        case GL_INVALID_VALUE: return "GL_INVALID_VALUE";
        case GL_INVALID_OPERATION: return "GL_INVALID_OPERATION";
        case GL_INVALID_FRAMEBUFFER_OPERATION: return "GL_INVALID_FRAMEBUFFER_OPERATION";
        case GL_OUT_OF_MEMORY: return "GL_OUT_OF_MEMORY";
        default: return "GL error " + std::to_string(code);
    }
}

std::string framebuffer_error(GLenum status) {
    switch (status) {
        case GL_FRAMEBUFFER_UNSUPPORTED: return "GL_FRAMEBUFFER_UNSUPPORTED";
        case GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT: return "GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT";
        default: return "framebuffer status " + std::to_string(status);
    }
}

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

Texture make_texture(GLenum target, GLint filter, GLint wrap) {
    GLuint id = 0;
    glGenTextures(1, &id);
    glBindTexture(target, id);
    glTexParameteri(target, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(target, GL_TEXTURE_MAG_FILTER, filter);
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
        glTexParameteri(target, axis, wrap);
    return Texture(id);
}

}  // namespace

void check_gl(const std::string& pass) {
    if (const GLenum code = glGetError(); code != GL_NO_ERROR)
        throw GLError(pass + ": " + error_name(code) +
                      (code == GL_OUT_OF_MEMORY ? "; a smaller picture or quality: preview needs less" : ""));
}

Buffer make_buffer() {
    GLuint id = 0;
    glGenBuffers(1, &id);
    return Buffer(id);
}

void upload(const Buffer& buffer, const void* data, std::size_t bytes) {
    glBindBuffer(GL_ARRAY_BUFFER, buffer.id());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(bytes), data, GL_STREAM_DRAW);
}

VertexArray make_vertex_array(const Buffer& buffer, std::initializer_list<int> floats_per_attribute,
                              int each) {
    GLuint id = 0;
    glGenVertexArrays(1, &id);
    glBindVertexArray(id);
    glBindBuffer(GL_ARRAY_BUFFER, buffer.id());
    std::size_t stride = 0, offset = 0;
    for (const int floats : floats_per_attribute) stride += sizeof(float) * static_cast<std::size_t>(floats);
    const auto step = static_cast<GLsizei>(stride) * each;
    GLuint attribute = 0;
    for (const int floats : floats_per_attribute) {
        glEnableVertexAttribArray(attribute);
        glVertexAttribPointer(attribute++, floats, GL_FLOAT, GL_FALSE, step,
                              reinterpret_cast<const void*>(offset));
        offset += sizeof(float) * static_cast<std::size_t>(floats);
    }
    return VertexArray(id);
}

Texture make_texture_2d(GLenum internal_format, int width, int height, GLint filter) {
    Texture texture = make_texture(GL_TEXTURE_2D, filter, GL_CLAMP_TO_EDGE);
    glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(internal_format), width, height, 0, GL_RGBA, GL_FLOAT,
                 nullptr);
    check_gl("a texture of " + std::to_string(width) + "×" + std::to_string(height));
    return texture;
}

Texture make_depth_stencil_texture(int width, int height) {
    Texture texture = make_texture(GL_TEXTURE_2D, GL_NEAREST, GL_CLAMP_TO_EDGE);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH24_STENCIL8, width, height, 0, GL_DEPTH_STENCIL,
                 GL_UNSIGNED_INT_24_8, nullptr);
    check_gl("a depth buffer of " + std::to_string(width) + "×" + std::to_string(height));
    return texture;
}

Texture make_shadow_texture(int size) {
    Texture texture = make_texture(GL_TEXTURE_2D, GL_LINEAR, GL_CLAMP_TO_BORDER);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, size, size, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                 nullptr);
    const float far_away[4] = {1, 1, 1, 1};
    glTexParameterfv(GL_TEXTURE_2D, GL_TEXTURE_BORDER_COLOR, far_away);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    check_gl("a shadow map of " + std::to_string(size) + "²");
    return texture;
}

static Sampler make_reader(GLint minify, GLint magnify) {
    GLuint id = 0;
    glGenSamplers(1, &id);
    glSamplerParameteri(id, GL_TEXTURE_MIN_FILTER, minify);
    glSamplerParameteri(id, GL_TEXTURE_MAG_FILTER, magnify);
    return Sampler(id);
}

Sampler make_depth_reader(int unit) {
    Sampler sampler = make_reader(GL_NEAREST, GL_NEAREST);
    glSamplerParameteri(sampler.id(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glSamplerParameteri(sampler.id(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glSamplerParameteri(sampler.id(), GL_TEXTURE_COMPARE_MODE, GL_NONE);
    glBindSampler(static_cast<GLuint>(unit), sampler.id());
    return sampler;
}

Sampler make_mipmap_reader() { return make_reader(GL_LINEAR_MIPMAP_NEAREST, GL_LINEAR); }

Texture make_volume_texture() { return make_texture(GL_TEXTURE_3D, GL_LINEAR, GL_CLAMP_TO_EDGE); }

Texture make_tile_texture(int size, const std::uint8_t* texels) {
    Texture texture = make_texture(GL_TEXTURE_2D, GL_LINEAR, GL_REPEAT);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, size, size, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels);
    glGenerateMipmap(GL_TEXTURE_2D);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    check_gl("a tile of " + std::to_string(size) + "² texels");
    return texture;
}

Texture make_strip_texture(int size, const std::uint8_t* texels) {
    Texture texture = make_texture(GL_TEXTURE_2D, GL_LINEAR, GL_CLAMP_TO_EDGE);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, size, 1, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels);
    check_gl("a strip of " + std::to_string(size) + " texels");
    return texture;
}

Framebuffer make_framebuffer(const std::string& name, std::initializer_list<const Texture*> colours,
                             const Texture* depth, GLenum depth_attachment) {
    GLuint id = 0;
    glGenFramebuffers(1, &id);
    Framebuffer framebuffer(id);
    glBindFramebuffer(GL_FRAMEBUFFER, id);
    GLenum targets[8];
    GLsizei count = 0;
    for (const Texture* colour : colours) {
        targets[count] = GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(count);
        glFramebufferTexture2D(GL_FRAMEBUFFER, targets[count++], GL_TEXTURE_2D, colour->id(), 0);
    }
    if (depth) glFramebufferTexture2D(GL_FRAMEBUFFER, depth_attachment, GL_TEXTURE_2D, depth->id(), 0);
    glDrawBuffers(count, targets);
    if (const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER); status != GL_FRAMEBUFFER_COMPLETE)
        throw GLError("this OpenGL cannot draw into " + name + ": " + framebuffer_error(status));
    return framebuffer;
}

void bind_texture(int unit, GLenum target, const Texture& texture) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(target, texture.id());
}

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
void Program::set(const char* name, const std::vector<Eigen::Vector2f>& x) const {
    glUniform2fv(location(name), static_cast<GLsizei>(x.size()), x.data()->data());
}
void Program::set(const char* name, const Eigen::Vector3f& x) const {
    glUniform3fv(location(name), 1, x.data());
}
void Program::set(const char* name, const Eigen::Vector4f& x) const {
    glUniform4fv(location(name), 1, x.data());
}
void Program::set(const char* name, const std::vector<Eigen::Vector4f>& x) const {
    glUniform4fv(location(name), static_cast<GLsizei>(x.size()), x.data()->data());
}
void Program::set(const char* name, const Eigen::Matrix3f& x) const {
    glUniformMatrix3fv(location(name), 1, GL_FALSE, x.data());
}
void Program::set(const char* name, const Eigen::Matrix4f& x) const {
    glUniformMatrix4fv(location(name), 1, GL_FALSE, x.data());
}

}  // namespace firn
