/// Instruction sets. Files named *_kernels.cpp are compiled once for each, with BOB_ISA as the name of the namespace
/// that their code goes into; the best one that the machine has is chosen at run time.
#pragma once

#include <string_view>

namespace bob {

enum class Isa { baseline, avx2, avx512 };

/// Numbers in the widest vectors of any instruction set.
constexpr int max_lanes = 16;

/// The instruction set in use: at first, the best that both this build and this machine have.
[[nodiscard]] Isa isa();

/// Uses another instruction set, for tests and benchmarks; false where this machine lacks it.
bool set_isa(Isa isa);

[[nodiscard]] std::string_view name(Isa isa);

/// Picks this machine's variant from a table of kernels that every instruction set defines under the same name.
#ifdef BOB_X86
#define BOB_DECLARE_KERNELS(Type, table)                           \
    namespace baseline { extern const Type table; }                \
    namespace avx2 { extern const Type table; }                    \
    namespace avx512 { extern const Type table; }                  \
    inline const Type& best_##table() {                            \
        return isa() == Isa::avx512 ? avx512::table                \
               : isa() == Isa::avx2 ? avx2::table                  \
                                    : baseline::table;             \
    }
#else
#define BOB_DECLARE_KERNELS(Type, table)            \
    namespace baseline { extern const Type table; } \
    inline const Type& best_##table() { return baseline::table; }
#endif

}  // namespace bob
