/// Parts of C++ that zig's library for WebAssembly leaves out, or writes to a terminal. The rest of the exception
/// support is compiled from the library's own sources (wasm.cmake).

#include <exception>

/// WebAssembly's tag of C++ exceptions: each carries the address of an object.
__asm__(
    ".globl __cpp_exception\n"
    ".tagtype __cpp_exception i32\n"
    "__cpp_exception:\n");

/// Destructors at the end of a thread: the only thread never ends.
extern "C" int __cxa_thread_atexit(void (*)(void*), void*, void*) { return 0; }

/// A fatal error ends in a trap, a WebAssembly.RuntimeError for a page. Without a message, no terminal function needs to
/// be imported.
extern "C" [[noreturn]] void __abort_message(const char*, ...) { __builtin_trap(); }

_LIBCPP_BEGIN_NAMESPACE_STD
[[noreturn]] void __libcpp_verbose_abort(const char*, ...) noexcept { __builtin_trap(); }
_LIBCPP_END_NAMESPACE_STD
