/// What the files of the WebAssembly module share: exported functions that report errors, and objects as handles.
///
/// A handle is the address of an object; `free_NAME` ends it. What fails returns 0, and `error()` then says why in one
/// line. Arrays are addresses in the module's memory, of what viewer/core/core.js put there.
#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <string>

#include "picture/camera.h"
#include "picture/channels.h"

#define EXPORT(name) extern "C" [[gnu::visibility("default"), clang::export_name(#name)]]

/// What went wrong last.
std::string& error_text();

inline void expect(bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(what);
}

/// Of samples, and of the planes in which a tracer keeps what they say.
inline const bob::Layout& traced_layout(bool is_colored) { return bob::remembered_layout(is_colored); }

/// Of a G-buffer's planes: what of these a picture shows. It comes first there.
inline const bob::Layout& shown_layout(bool is_colored) { return is_colored ? bob::colored_layout() : bob::gbuffer_layout(); }

/// The numbers of a camera that orbits, in the order of bob::Camera.
inline bob::Camera camera_of(const float* n) { return {n[0], n[1], n[2], n[3], n[4], n[5], n[6]}; }

/// f(), or 0 where it throws.
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
