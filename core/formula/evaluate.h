/// Evaluating formulas many times over: at points, with gradients, over boxes, and along rays to the first root.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "base/isa.h"
#include "formula/expression.h"

namespace bob {

/// scale * a + offset: sums and products with constants, negation.
constexpr Op affine = static_cast<Op>(op_count);

/// Where two things meet at right angles, a and b being the distances from each: the larger where either is negative,
/// else hypot(a, b). A select, but one that does not jump.
constexpr Op corner_distance = static_cast<Op>(op_count + 1);

/// A select that `meets`.
constexpr Op piecewise_select = static_cast<Op>(op_count + 2);

/// How many registers an instruction reads.
constexpr int operands_of(Op op) { return op == affine ? 1 : op == corner_distance ? 2 : op == piecewise_select ? 3 : operands(op); }

constexpr bool is_select(Op op) { return op == Op::select || op == piecewise_select; }

/// 20 bytes, without gaps: code that is the same is the same in memory.
struct Instruction {
    Op op;
    std::uint8_t unused = 0;
    std::uint16_t out, a, b, c;  // registers; 0 where there is no operand
    std::uint16_t unused_too = 0;
    float scale, offset;  // of `affine`; a constant's value is in offset, a power's exponent in scale; both hold a mesh's address
};
static_assert(sizeof(Instruction) == 20);

/// The mesh of an instruction, which whoever holds the code keeps.
inline void set_mesh(Instruction& instruction, const MeshDistance* mesh) {
    static_assert(sizeof mesh <= 2 * sizeof(float));
    std::memcpy(&instruction.scale, &mesh, sizeof mesh);
}
inline const MeshDistance& mesh_of(const Instruction& instruction) {
    const MeshDistance* mesh;
    std::memcpy(&mesh, &instruction.scale, sizeof mesh);
    return *mesh;
}

/// A formula as instructions in order; registers 0, 1 and 2 hold x, y and z.
struct Code {
    const Instruction* instructions;
    std::size_t count;
    int registers;
    int result;     // the register that holds the value at the end
    bool may_jump;  // whether any of the ops may
};

/// Bytes of scratch memory, aligned to 64, that a kernel needs for each register.
constexpr std::size_t register_bytes = 512;

/// The outcome of one decision (see is_decision) in each of several boxes: bit i is for box i.
///
/// A minimum or maximum is always a (first) or always b (second); a select always b or always c; a corner always the larger
/// or always the hypotenuse; an absolute always a or always -a. A rounding always gives `value` (first), or that or the next number (second). An atan2 jumps in the box, and
/// its x is negative there (first).
struct Decision {
    std::uint32_t first = 0, second = 0;
    float value[max_lanes] = {};
};

constexpr bool is_rounding(Op op) { return op == Op::floor || op == Op::ceil || op == Op::round; }

/// Whether an op may jump although its operands do not.
constexpr bool may_jump(Op op) { return op == Op::select || op == Op::atan2 || is_rounding(op); }

/// Whether a box may decide something about an op.
constexpr bool is_decision(Op op) {
    return op == Op::minimum || op == Op::maximum || op == Op::absolute || op == corner_distance || op == piecewise_select || may_jump(op);
}

/// Whether box `lane` decides it, so that less is to be computed there.
constexpr bool is_decided(Op op, const Decision& decision, int lane) {
    const bool first = decision.first >> lane & 1, second = decision.second >> lane & 1;
    return (first && op != Op::atan2) || (second && !is_rounding(op) && op != Op::atan2);
}

/// Axis-aligned boxes and what a formula's values are in them.
struct BoxBatch {
    float low[3][max_lanes], high[3][max_lanes];  // [axis][box]: in
    float least[max_lanes], most[max_lanes];      // out: every value lies between; NaN where nothing is known
    std::uint32_t partly;                         // out: bit i: box i may hold points where the formula is NaN
    std::uint32_t nowhere;                        // out: bit i: it is NaN everywhere in box i
    float least_slope[3][max_lanes], most_slope[3][max_lanes];  // out of `narrow`: of every slope; NaN where unknown, or where they tell less than `least` and `most`
};

/// Whether f may change its sign in box i, as far as `boxes` shows.
inline bool may_change_sign(const BoxBatch& boxes, int i) {
    return !(boxes.least[i] >= 0 || boxes.most[i] < 0 || boxes.nowhere >> i & 1);
}

/// A piece of a ray, from t = 0 on, and where a formula has its first root there. The first 16 numbers are a row of a table whose columns
/// vectors read (formula/first_roots.h).
struct Segment {
    float origin[3], direction[3];
    float t_end;                    // above 0
    float finest;                   // roots closer together than this are not separated
    float least_slope, most_slope;  // the formula's slopes along the segment lie between; NaN or infinite where unknown
    float a, fa, b, fb;             // the kernel's own: where what is left to be searched begins and ends, or the two sides of the root, and the values there
    float inner[2];                 // the kernel's own: f between the ends, where few segments are searched at once
    float doubt;                    // the kernel's own: where the first part of it begins in which roots are unresolved
    float t;                        // out: where there is a root
    bool found;                     // out: whether there is
    bool unresolved;                // out: before that, there may be an even number of roots closer than `finest`
    bool open;                      // the kernel's own: whether it is still looking
};

struct FormulaKernels {
    /// Boxes or points that one batch holds.
    int lanes;

    /// f at `count` points, at most `lanes`; coordinates by axis.
    void (*values)(const Code& code, const float* const point[3], int count, float* value, void* scratch);

    /// The same of code with three results, in the registers `results` at the end.
    void (*colors)(const Code& code, const int results[3], const float* const point[3], int count, float* const color[3],
                   void* scratch);

    /// The gradient too, by axis; `across_jumps`: where f is not zero and jumps within 1e-5, as far as slopes show, that of what jumps
    /// there, which is normal to the jump.
    void (*gradients)(const Code& code, const float* const point[3], int count, bool across_jumps, float* value,
                      float* const gradient[3], void* scratch);

    /// Bounds of f in each box, and what the boxes decide: one Decision for each op that is one, in the code's order; for
    /// a corner two, the first of which is its maximum's.
    void (*bounds)(const Code& code, BoxBatch& boxes, Decision* decisions, void* scratch);

    /// Narrows `least` and `most` of boxes that `bounds` was called for: f is no farther from its value at the box's
    /// centre than its slopes within the box allow. Sharper than bounds of the values alone where boxes are small,
    /// since terms in x that cancel each other also cancel in the slope.
    void (*narrow)(const Code& code, BoxBatch& boxes, void* scratch);

    /// Where f first changes its sign along each of `count` segments. Nothing is assumed of f: bounds of its values and
    /// slopes over shrinking pieces of the segment show where it can't change, and where it must. A jump counts as a
    /// change, a pole does not; nor does a point where f is NaN. What is found on a segment depends on that one alone;
    /// many in one call fill the lanes best.
    void (*first_roots)(const Code& code, Segment* segments, std::size_t count, void* scratch);
};

BOB_DECLARE_KERNELS(FormulaKernels, formula_kernels)

/// The kernels for that many segments or points at once. Few leave most lanes of the widest vectors empty, and take a tenth less time in
/// narrower ones, which find the same to the bit.
inline const FormulaKernels& formula_kernels_for(std::size_t count) {
#ifdef BOB_X86
    constexpr std::size_t few = 6;  // with 2, 5 % of the rays of letters or a vase take a tenth longer; with 4 or 8, as long
    if (count <= few && isa() == Isa::avx512) return avx2::formula_kernels;
#else
    (void)count;
#endif
    return best_formula_kernels();
}

}  // namespace bob
