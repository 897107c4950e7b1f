/// Threads for a module with memory shared by workers: lent threads, and the thread-safe parts that zig's library
/// lacks.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <new>

#include "base/mutex.h"
#include "base/parallel.h"
#include "base/parallel_lent.h"
#include "wasm.h"

// ---- Memory ----------------------------------------------------------------------------------------------------

namespace {

bob::Mutex allocating;

void* allocated(std::size_t size, std::size_t alignment) {
    const std::size_t whole = (std::max<std::size_t>(size, 1) + alignment - 1) / alignment * alignment;
    const std::lock_guard lock(allocating);
    return std::aligned_alloc(alignment, whole);
}

void* allocated_or_thrown(std::size_t size, std::size_t alignment) {
    void* const memory = allocated(size, alignment);
    if (!memory) throw std::bad_alloc();
    return memory;
}

void freed(void* memory) {
    const std::lock_guard lock(allocating);
    std::free(memory);
}

constexpr std::size_t usual = alignof(std::max_align_t);

}  // namespace

// All other forms call these.
void* operator new(std::size_t size) { return allocated_or_thrown(size, usual); }
void* operator new(std::size_t size, std::align_val_t alignment) { return allocated_or_thrown(size, static_cast<std::size_t>(alignment)); }
void operator delete(void* memory) noexcept { freed(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { freed(memory); }

/// Memory for exceptions.
namespace __cxxabiv1 {

void* __aligned_malloc_with_fallback(std::size_t size) { return allocated(size, usual); }
void __aligned_free_with_fallback(void* memory) { freed(memory); }

}  // namespace __cxxabiv1

// ---- Objects that are made when they are first asked for (Itanium C++ ABI, 3.3.3) ----------------------------

namespace {

enum : std::uint8_t { nothing = 0, made = 1 };

/// Compiled code reads the first byte: whether the object exists. A thread that constructs it takes the second.
struct Guard {
    std::atomic<std::uint8_t> state;
    std::atomic_flag taken;
};
static_assert(sizeof(Guard) <= sizeof(std::int32_t), "WebAssembly's guards are of 32 bits");

}  // namespace

extern "C" {

int __cxa_guard_acquire(Guard* guard) {
    while (guard->state != made) {
        if (!guard->taken.test_and_set()) {
            if (guard->state != made) return 1;
            guard->taken.clear();
        }
    }
    return 0;
}

void __cxa_guard_release(Guard* guard) {
    guard->state = made;
    guard->taken.clear();
}

void __cxa_guard_abort(Guard* guard) { guard->taken.clear(); }

}  // extern "C"

// ---- Exceptions that this thread has caught (Itanium C++ ABI, 2.2.2) -----------------------------------------

namespace {

struct Caught {
    void* exceptions;
    unsigned uncaught;
};

}  // namespace

extern "C" {

Caught* __cxa_get_globals() {
    thread_local Caught caught{};
    return &caught;
}

Caught* __cxa_get_globals_fast() { return __cxa_get_globals(); }

void __wasm_init_tls(void* memory);

}  // extern "C"

// ---- Threads -------------------------------------------------------------------------------------------------

/// Lends this thread, whose stack is set, to the core; never returns.
EXPORT(lend_thread) void lend_thread() {
    __wasm_init_tls(allocated_or_thrown(__builtin_wasm_tls_size(), __builtin_wasm_tls_align()));
    bob::lend_thread();
}

/// Sets the number of working threads, at most all that were lent, and returns it.
EXPORT(set_threads) int set_threads(int count) {
    bob::set_thread_count(count);
    return bob::thread_count();
}
