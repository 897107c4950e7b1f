/// Shared parts of the WebAssembly modules: exported functions that report errors, and objects as handles.
///
/// A handle is the address of an object; `free_NAME` destroys it. On failure a function returns 0, and `error()` gives
/// the reason in one line. Arrays are addresses in the module's memory, filled by viewer/core/core.js.
#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <string>

#include "picture/camera.h"
#include "picture/channels.h"

#define EXPORT(name) extern "C" [[gnu::visibility("default"), clang::export_name(#name)]]

/// The last error.
std::string& error_text();

inline void expect(bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(what);
}

/// The layout of samples, and of a tracer's planes.
inline const bob::Layout& traced_layout(bool is_colored) { return bob::remembered_layout(is_colored); }

/// The displayed channels of a G-buffer's planes, which come first there.
inline const bob::Layout& shown_layout(bool is_colored) { return is_colored ? bob::colored_layout() : bob::gbuffer_layout(); }

/// The parameters of an orbiting camera, in the order of bob::Camera.
inline bob::Camera camera_of(const float* n) { return {n[0], n[1], n[2], n[3], n[4], n[5], n[6]}; }

/// f(), or 0 if it throws.
template <class F>
auto attempt(F f) -> decltype(f()) {
    try {
        return f();
    } catch (const std::bad_alloc&) {
        error_text() = "out of memory: a WebAssembly module has at most 4 GiB";
    } catch (const std::exception& error) {
        error_text() = error.what();
    }
    return {};
}
