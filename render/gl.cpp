#include "render/gl.h"

#include "render/renderer.h"

#include <algorithm>

namespace firn {

void delete_buffer(GLuint id) { glDeleteBuffers(1, &id); }
void delete_vertex_array(GLuint id) { glDeleteVertexArrays(1, &id); }
void delete_texture(GLuint id) { glDeleteTextures(1, &id); }
void delete_framebuffer(GLuint id) { glDeleteFramebuffers(1, &id); }
void delete_sampler(GLuint id) { glDeleteSamplers(1, &id); }

namespace {

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

Texture make_tile_texture(int size, const std::vector<std::vector<std::uint8_t>>& levels) {
    Texture texture = make_texture(GL_TEXTURE_2D, GL_LINEAR, GL_REPEAT);
    for (GLint level = 0; level < static_cast<GLint>(levels.size()); ++level)
        glTexImage2D(GL_TEXTURE_2D, level, GL_RGBA8, size >> level, size >> level, 0, GL_RGBA,
                     GL_UNSIGNED_BYTE, levels[level].data());
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
    if (count == 0) glReadBuffer(GL_NONE);  // 3.3 calls it incomplete otherwise
    if (const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER); status != GL_FRAMEBUFFER_COMPLETE)
        throw GLError("this OpenGL cannot draw into " + name + ": " + framebuffer_error(status));
    return framebuffer;
}

void bind_texture(int unit, GLenum target, const Texture& texture) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(target, texture.id());
}

void draw_many(GLenum what, GLint first, GLsizei count, GLsizei instances) {
    const GLsizei portion = std::max((1 << 15) / instances, 1) * 2;  // both ends of a line are in one
    GLsync before = nullptr;
    for (GLsizei done = 0; done < count; done += portion) {
        glDrawArraysInstanced(what, first + done, std::min(portion, count - done), instances);
        const GLsync drawn = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
        if (before) glClientWaitSync(before, GL_SYNC_FLUSH_COMMANDS_BIT, GL_TIMEOUT_IGNORED);
        glDeleteSync(before);
        before = drawn;
    }
    glDeleteSync(before);
}

}  // namespace firn
