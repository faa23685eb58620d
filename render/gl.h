#pragma once
#include <epoxy/gl.h>

#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

namespace firn {

/// Throws GLError with the pass's name if an OpenGL call since the last check failed.
void check_gl(const std::string& pass);

/// Owns one OpenGL object; `destroy` deletes it. The context must be current when it ends.
template <void (*destroy)(GLuint)>
class GLObject {
public:
    explicit GLObject(GLuint id = 0) : id_(id) {}
    GLObject(GLObject&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
    GLObject& operator=(GLObject&& other) noexcept {
        std::swap(id_, other.id_);
        return *this;
    }
    ~GLObject() {
        if (id_) destroy(id_);
    }
    GLuint id() const { return id_; }

private:
    GLuint id_;
};

void delete_buffer(GLuint);
void delete_vertex_array(GLuint);
void delete_texture(GLuint);
void delete_framebuffer(GLuint);
void delete_sampler(GLuint);
using Buffer = GLObject<delete_buffer>;
using VertexArray = GLObject<delete_vertex_array>;
using Texture = GLObject<delete_texture>;
using Sampler = GLObject<delete_sampler>;
using Framebuffer = GLObject<delete_framebuffer>;

/// Attribute k of the shader is the k-th entry: that many floats, one after the other, from every `each`-th
/// record of the buffer.
VertexArray make_vertex_array(const Buffer&, std::initializer_list<int> floats_per_attribute, int each = 1);
Buffer make_buffer();
void upload(const Buffer&, const void* data, std::size_t bytes);  ///< Replaces what it held.

/// Empty; clamped.
Texture make_texture_2d(GLenum internal_format, int width, int height, GLint filter = GL_NEAREST);
Texture make_depth_stencil_texture(int width, int height);
/// Depth texture that compares when it is sampled (sampler2DShadow), lit outside.
Texture make_shadow_texture(int size);
/// Reads such a texture as plain numbers, wherever it is bound at that unit.
Sampler make_depth_reader(int unit);
/// Reads a tile from the nearest of its smaller versions alone.
Sampler make_mipmap_reader();
/// Empty 3D texture; linear, clamped.
Texture make_volume_texture();
/// RGBA, 8 bits a channel, with all its smaller versions, each of half the size; linear, repeats.
Texture make_tile_texture(int size, const std::vector<std::vector<std::uint8_t>>& levels);
/// RGBA, 8 bits a channel, one row; linear, clamped.
Texture make_strip_texture(int size, const std::uint8_t* texels);
/// Throws GLError with the name, which tells the formats, where the combination cannot be drawn into.
Framebuffer make_framebuffer(const std::string& name, std::initializer_list<const Texture*> colours, const Texture* depth = nullptr,
                             GLenum depth_attachment = GL_DEPTH_ATTACHMENT);
void bind_texture(int unit, GLenum target, const Texture&);

/// Draws `count` points, or vertices of lines, from `first` on, `instances` times. At most two portions of them
/// wait at a time: a driver that draws on processors lists on which tiles each of those lies that wait.
void draw_many(GLenum what, GLint first, GLsizei count, GLsizei instances = 1);

}  // namespace firn
