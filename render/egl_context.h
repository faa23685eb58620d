#pragma once
#define EGL_NO_X11
#include <epoxy/egl.h>

#include <string>

namespace firn {

/// An OpenGL 3.3 core context without a window. Tried in this order: the device that FIRN_EGL_DEVICE=N names
/// (and nothing else); hardware devices; Mesa's surfaceless platform; the software device. A context belongs
/// to the thread that made it.
class EglContext {
public:
    EglContext();  ///< Leaves the context current. Throws GLError with every attempt and its error.
    ~EglContext();
    EglContext(const EglContext&) = delete;
    EglContext& operator=(const EglContext&) = delete;

    void make_current() const;
    const std::string& description() const { return description_; }  ///< vendor, renderer, version.

private:
    struct Candidate;
    void open(const Candidate&);
    void close();

    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLSurface surface_ = EGL_NO_SURFACE;  ///< 1×1, only where contexts without a surface are not supported.
    EGLContext context_ = EGL_NO_CONTEXT;
    std::string description_;
};

}  // namespace firn
