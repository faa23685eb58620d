#pragma once
#include "render/gl.h"

#include <Eigen/Core>

#include <map>
#include <set>
#include <string>
#include <vector>

namespace firn {

void delete_program(GLuint);

/// A vertex and a fragment shader, linked. Each is one or more files of shaders/, joined, behind common.glsl.
/// Both find the constants defined.
class Program {
public:
    Program(const std::vector<std::string>& vertex_files, const std::vector<std::string>& fragment_files,
            const std::map<std::string, int>& constants = {});
    /// Throws GLError if it was used before and one of its uniforms has not been set since it was linked.
    void use() const;

    // Of the program in use. A name that the linker has dropped is no error.
    void set(const char* name, int) const;
    void set(const char* name, float) const;
    void set(const char* name, const Eigen::Vector2f&) const;
    void set(const char* name, const Eigen::Vector3f&) const;
    void set(const char* name, const Eigen::Vector4f&) const;
    void set(const char* name, const std::vector<Eigen::Vector4f>&) const;
    void set(const char* name, const Eigen::Matrix3f&) const;
    void set(const char* name, const Eigen::Matrix4f&) const;

private:
    GLint location(const char* name) const;

    std::string name_;  ///< of its files.
    GLObject<delete_program> program_;
    mutable std::set<std::string> unset_;  ///< uniforms; arrays end in [0].
    mutable bool used_ = false;
};

}  // namespace firn
