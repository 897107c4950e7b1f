/// Memory for the registers of formulas under evaluation.
#pragma once

#include <cstddef>
#include <memory>
#include <new>

#include "formula/evaluate.h"

namespace bob {

/// This thread's scratch memory for code with `registers` registers; invalidates the last call's.
inline void* scratch(int registers) {
    constexpr std::align_val_t alignment{64};
    struct Release {
        void operator()(void* p) const { ::operator delete(p, alignment); }
    };
    thread_local std::unique_ptr<void, Release> memory;
    thread_local std::size_t size = 0;
    const std::size_t wanted = static_cast<std::size_t>(registers) * register_bytes;
    if (wanted > size) {
        memory.reset(::operator new(wanted, alignment));
        size = wanted;
    }
    return memory.get();
}

}  // namespace bob
