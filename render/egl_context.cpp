#include "render/egl_context.h"

#include "render/renderer.h"

#include <dlfcn.h>
#include <epoxy/gl.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <sstream>

namespace firn {

/// A display to try: a device of the list, or the surfaceless platform.
struct EglContext::Candidate {
    std::string name;
    EGLenum platform;
    void* native;
};

namespace {

std::string egl_error() {
    switch (const EGLint code = eglGetError()) {
        case EGL_SUCCESS:
            return "no reason given";
        case EGL_NOT_INITIALIZED:
            return "EGL_NOT_INITIALIZED";
        case EGL_BAD_ACCESS:
            return "EGL_BAD_ACCESS";
        case EGL_BAD_ALLOC:
            return "EGL_BAD_ALLOC";
        case EGL_BAD_ATTRIBUTE:
            return "EGL_BAD_ATTRIBUTE";
        case EGL_BAD_CONFIG:
            return "EGL_BAD_CONFIG";
        case EGL_BAD_CONTEXT:
            return "EGL_BAD_CONTEXT";
        case EGL_BAD_DISPLAY:
            return "EGL_BAD_DISPLAY";
        case EGL_BAD_MATCH:
            return "EGL_BAD_MATCH";
        case EGL_BAD_PARAMETER:
            return "EGL_BAD_PARAMETER";
        case EGL_BAD_SURFACE:
            return "EGL_BAD_SURFACE";
        case EGL_CONTEXT_LOST:
            return "EGL_CONTEXT_LOST";
        case EGL_BAD_DEVICE_EXT:
            return "EGL_BAD_DEVICE_EXT";
        default: {
            char text[32];
            std::snprintf(text, sizeof text, "EGL error 0x%04x", unsigned(code));
            return text;
        }
    }
}

/// Extension lists are words with single spaces between them, or null.
bool has_word(const char* list, const std::string& word) {
    std::istringstream words(list ? list : "");
    for (std::string w; words >> w;)
        if (w == word) return true;
    return false;
}

template <class Function>
Function entry_point(const char* name) {
    const auto function = reinterpret_cast<Function>(eglGetProcAddress(name));
    if (!function) throw GLError(std::string("this EGL has no ") + name);
    return function;
}

struct Device {
    EGLDeviceEXT handle;
    bool software;
};

std::vector<Device> devices(const char* client_extensions) {
    const bool listed = has_word(client_extensions, "EGL_EXT_device_base") ||
                        (has_word(client_extensions, "EGL_EXT_device_enumeration") &&
                         has_word(client_extensions, "EGL_EXT_device_query"));
    if (!listed || !has_word(client_extensions, "EGL_EXT_platform_device")) return {};
    const auto query_devices = entry_point<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
    const auto query_string = entry_point<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");

    EGLint count = 0;
    if (!query_devices(0, nullptr, &count) || count < 1) return {};
    std::vector<EGLDeviceEXT> handles(static_cast<std::size_t>(count));
    if (!query_devices(count, handles.data(), &count)) return {};
    std::vector<Device> result;
    for (int i = 0; i < count; ++i) {
        const char* extensions = query_string(handles[i], EGL_EXTENSIONS);
        result.push_back({handles[i], has_word(extensions, "EGL_MESA_device_software")});
    }
    return result;
}

/// Where a GPU cannot be used, this is what a machine lacks.
const char* const advice =
    "\nA software OpenGL comes with: apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri libopengl0";

/// libepoxy loads these when they are first needed, and ends the program where it finds none.
void require_libraries() {
    const auto found = [](const char* name) { return dlopen(name, RTLD_LAZY) != nullptr; };
    if (!found("libEGL.so.1")) throw GLError(std::string("no OpenGL: libEGL.so.1 cannot be loaded") + advice);
    if (!found("libOpenGL.so.0") && !found("libGL.so.1"))
        throw GLError(std::string("no OpenGL: neither libOpenGL.so.0 nor libGL.so.1 can be loaded") + advice);
}

std::size_t device_index(const char* text, std::size_t count) {
    std::size_t index = 0;
    const char* end = text + std::string_view(text).size();
    const auto [stop, error] = std::from_chars(text, end, index);
    if (error != std::errc() || stop != end || index >= count)
        throw GLError(std::string("FIRN_EGL_DEVICE=") + text + " names no device: EGL lists " +
                      std::to_string(count) + (count ? ", counted from 0" : "") + advice);
    return index;
}

}  // namespace

EglContext::EglContext() {
    require_libraries();
    const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (!client || !has_word(client, "EGL_EXT_platform_base"))
        throw GLError("no OpenGL: no EGL driver is installed (" + egl_error() + ")" + advice);

    const std::vector<Device> listed = devices(client);
    std::vector<Candidate> candidates;
    const auto add_device = [&](std::size_t i) {
        candidates.push_back({"EGL device " + std::to_string(i) + (listed[i].software ? " (software)" : ""),
                              EGL_PLATFORM_DEVICE_EXT, listed[i].handle});
    };
    const auto add_devices = [&](bool software) {
        for (std::size_t i = 0; i < listed.size(); ++i)
            if (listed[i].software == software) add_device(i);
    };
    if (const char* chosen = std::getenv("FIRN_EGL_DEVICE")) {
        add_device(device_index(chosen, listed.size()));
    } else {
        // Mesa refuses a hardware device while software is asked for.
        if (!std::getenv("LIBGL_ALWAYS_SOFTWARE")) add_devices(false);
        if (has_word(client, "EGL_MESA_platform_surfaceless"))
            candidates.push_back({"surfaceless", EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY});
        add_devices(true);
    }

    std::string attempts;
    for (const Candidate& candidate : candidates) {
        try {
            open(candidate);
            return;
        } catch (const GLError& error) {
            close();
            attempts += "\n  " + candidate.name + ": " + error.what();
        }
    }
    throw GLError("no usable OpenGL 3.3; tried" +
                  (attempts.empty() ? " nothing: EGL offers no display" : attempts) + advice);
}

void EglContext::open(const Candidate& candidate) {
    const auto fail = [](const char* call) { throw GLError(std::string(call) + ": " + egl_error()); };
    const auto get_display = entry_point<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    display_ = get_display(candidate.platform, candidate.native, nullptr);
    if (display_ == EGL_NO_DISPLAY) fail("eglGetPlatformDisplayEXT");
    if (!eglInitialize(display_, nullptr, nullptr)) fail("eglInitialize");
    if (!eglBindAPI(EGL_OPENGL_API)) fail("eglBindAPI(EGL_OPENGL_API)");

    const char* extensions = eglQueryString(display_, EGL_EXTENSIONS);
    const bool no_surface = has_word(extensions, "EGL_KHR_surfaceless_context");
    EGLConfig config = nullptr;
    if (!no_surface || !has_word(extensions, "EGL_KHR_no_config_context")) {
        const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE,
                                 no_surface ? 0 : EGL_PBUFFER_BIT, EGL_NONE};
        EGLint count = 0;
        if (!eglChooseConfig(display_, wanted, &config, 1, &count)) fail("eglChooseConfig");
        if (count < 1) throw GLError("eglChooseConfig: no configuration draws OpenGL off screen");
    }
    if (!no_surface) {
        const EGLint size[] = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
        surface_ = eglCreatePbufferSurface(display_, config, size);
        if (surface_ == EGL_NO_SURFACE) fail("eglCreatePbufferSurface");
    }
    const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION,
                              3,
                              EGL_CONTEXT_MINOR_VERSION,
                              3,
                              EGL_CONTEXT_OPENGL_PROFILE_MASK,
                              EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                              EGL_NONE};
    context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, version);
    if (context_ == EGL_NO_CONTEXT) fail("eglCreateContext (OpenGL 3.3 core)");
    make_current();

    const auto text = [](GLenum name) {
        const GLubyte* s = glGetString(name);
        return s ? std::string(reinterpret_cast<const char*>(s)) : std::string("?");
    };
    description_ = text(GL_VENDOR) + ", " + text(GL_RENDERER) + ", OpenGL " + text(GL_VERSION);
    if (epoxy_gl_version() < 33) throw GLError("the context is older than OpenGL 3.3: " + description_);
}

void EglContext::make_current() const {
    if (!eglMakeCurrent(display_, surface_, surface_, context_))
        throw GLError("eglMakeCurrent: " + egl_error());
}

/// The display is not terminated: it is shared with every other context of the process on it.
void EglContext::close() {
    if (display_ == EGL_NO_DISPLAY) return;
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
    if (surface_ != EGL_NO_SURFACE) eglDestroySurface(display_, surface_);
    display_ = EGL_NO_DISPLAY, surface_ = EGL_NO_SURFACE, context_ = EGL_NO_CONTEXT;
}

EglContext::~EglContext() { close(); }

}  // namespace firn
