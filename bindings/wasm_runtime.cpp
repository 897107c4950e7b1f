/// What zig's C++ library leaves out for WebAssembly, or has for a terminal. The rest of the support for exceptions is
/// compiled from the library's own sources (wasm.cmake).

#include <exception>

/// The tag by which WebAssembly recognises C++ exceptions: each carries the address of an object.
__asm__(
    ".globl __cpp_exception\n"
    ".tagtype __cpp_exception i32\n"
    "__cpp_exception:\n");

/// Destructors for when a thread ends: the only thread never does.
extern "C" int __cxa_thread_atexit(void (*)(void*), void*, void*) { return 0; }

/// A fatal error ends in a trap, which a page sees as a WebAssembly.RuntimeError: without a message, no function that
/// writes to a terminal needs to be imported.
extern "C" [[noreturn]] void __abort_message(const char*, ...) { __builtin_trap(); }

_LIBCPP_BEGIN_NAMESPACE_STD
[[noreturn]] void __libcpp_verbose_abort(const char*, ...) noexcept { __builtin_trap(); }
_LIBCPP_END_NAMESPACE_STD
