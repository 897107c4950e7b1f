/// What the files of the WebAssembly module share: exported functions that report errors, and objects as handles.
///
/// A handle is the address of an object; `free_NAME` ends it. What fails returns 0, and `error()` then says why in one
/// line. Arrays are addresses in the module's memory, of what viewer/core/core.js put there.
#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <string>

#include "picture/channels.h"

#define EXPORT(name) extern "C" [[gnu::visibility("default"), clang::export_name(#name)]]

/// What went wrong last.
std::string& error_text();

inline void expect(bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(what);
}

/// Of samples and planes.
inline const bob::Layout& layout_of(bool is_colored) { return is_colored ? bob::colored_layout() : bob::gbuffer_layout(); }

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
