/// Batch evaluation of formulas: at points, with gradients, over boxes, and along rays to the first root.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "base/isa.h"
#include "formula/expression.h"

namespace bob {

/// scale * a + offset: sums and products with constants, negation.
constexpr Op affine = static_cast<Op>(op_count);

/// The distance from two surfaces that meet at right angles, given the distances a and b. The larger if either is
/// negative, else hypot(a, b). A select without a jump.
constexpr Op corner_distance = static_cast<Op>(op_count + 1);

/// A select without a jump: one that `meets`.
constexpr Op piecewise_select = static_cast<Op>(op_count + 2);

/// Number of registers that an instruction reads.
constexpr int operands_of(Op op) { return op == affine ? 1 : op == corner_distance ? 2 : op == piecewise_select ? 3 : operands(op); }

constexpr bool is_select(Op op) { return op == Op::select || op == piecewise_select; }

/// 20 bytes without padding: equal code is equal in memory.
struct Instruction {
    Op op;
    std::uint8_t unused = 0;
    std::uint16_t out, a, b, c;  // registers; 0 if there is no operand
    std::uint16_t unused_too = 0;
    float scale, offset;  // of `affine`; offset holds a constant's value, scale a power's exponent, and both together a mesh's address
};
static_assert(sizeof(Instruction) == 20);

/// Sets the mesh of an instruction; the owner of the code keeps it alive.
inline void set_mesh(Instruction& instruction, const MeshDistance* mesh) {
    static_assert(sizeof mesh <= 2 * sizeof(float));
    std::memcpy(&instruction.scale, &mesh, sizeof mesh);
}
inline const MeshDistance& mesh_of(const Instruction& instruction) {
    const MeshDistance* mesh;
    std::memcpy(&mesh, &instruction.scale, sizeof mesh);
    return *mesh;
}

/// A formula as a sequence of instructions; registers 0, 1 and 2 hold x, y and z.
struct Code {
    const Instruction* instructions;
    std::size_t count;
    int registers;
    int result;     // the register of the final value
    bool may_jump;  // whether any op may jump
};

/// Bytes of scratch memory that a kernel needs per register, aligned to 64.
constexpr std::size_t register_bytes = 512;

/// The outcome of one decision (see is_decision) in each of several boxes: bit i is for box i.
///
/// `first` and `second` of an op:
///
///     minimum, maximum   always a              always b
///     select             always b              always c
///     corner             always the larger     always the hypotenuse
///     absolute           always a              always -a
///     rounding           always `value`        `value` or the next number
///     atan2              jumps in the box,
///                        with negative x
struct Decision {
    std::uint32_t first = 0, second = 0;
    float value[max_lanes] = {};
};

constexpr bool is_rounding(Op op) { return op == Op::floor || op == Op::ceil || op == Op::round; }

/// Whether an op may jump although its operands do not.
constexpr bool may_jump(Op op) { return op == Op::select || op == Op::atan2 || is_rounding(op); }

/// Whether a box may decide an op.
constexpr bool is_decision(Op op) {
    return op == Op::minimum || op == Op::maximum || op == Op::absolute || op == corner_distance || op == piecewise_select || may_jump(op);
}

/// Whether box `lane` decides it and so saves work.
constexpr bool is_decided(Op op, const Decision& decision, int lane) {
    const bool first = decision.first >> lane & 1, second = decision.second >> lane & 1;
    return (first && op != Op::atan2) || (second && !is_rounding(op) && op != Op::atan2);
}

/// Axis-aligned boxes and bounds of a formula in them.
struct BoxBatch {
    float low[3][max_lanes], high[3][max_lanes];  // [axis][box]: in
    float least[max_lanes], most[max_lanes];      // out: bounds of all values; NaN if unknown
    std::uint32_t partly;                         // out: bit i: the formula may be NaN at points of box i
    std::uint32_t nowhere;                        // out: bit i: it is NaN everywhere in box i
    float least_slope[3][max_lanes], most_slope[3][max_lanes];  // out of `narrow`: slope bounds; NaN if unknown or looser than the value bounds
};

/// Whether f may change its sign in box i, judged by its bounds.
inline bool may_change_sign(const BoxBatch& boxes, int i) {
    return !(boxes.least[i] >= 0 || boxes.most[i] < 0 || boxes.nowhere >> i & 1);
}

/// A piece of a ray, from t = 0 on, and the formula's first root on it. The first 16 numbers are a row of a table that
/// vectors read by columns (formula/first_roots.h).
struct Segment {
    float origin[3], direction[3];
    float t_end;                    // above 0
    float finest;                   // closer roots are not separated
    float least_slope, most_slope;  // bounds of the formula's slopes along the segment; NaN or infinite if unknown
    float a, fa, b, fb;             // internal: the ends of the interval still to search, or the two sides of the root, and the values there
    float inner[2];                 // internal: f between the ends, if few segments are searched together
    float doubt;                    // internal: start of the first part with unresolved roots
    float t;                        // out: the root
    bool found;                     // out: whether there is a root
    bool unresolved;                // out: an even number of roots closer than `finest` may precede it
    bool open;                      // internal: whether the search goes on
};

struct FormulaKernels {
    /// Boxes or points in a batch.
    int lanes;

    /// f at `count` points, at most `lanes`; coordinates by axis.
    void (*values)(const Code& code, const float* const point[3], int count, float* value, void* scratch);

    /// The three results of code for colours, in the registers `results`.
    void (*colors)(const Code& code, const int results[3], const float* const point[3], int count, float* const color[3],
                   void* scratch);

    /// f and its gradient, by axis. With `across_jumps`, where f is not zero and jumps within 1e-5, estimated from
    /// slopes, the gradient of the jumping term, which is normal to the jump.
    void (*gradients)(const Code& code, const float* const point[3], int count, bool across_jumps, float* value,
                      float* const gradient[3], void* scratch);

    /// Bounds of f in each box, and the decisions of the boxes. One for each deciding op, in the code's order; two for a
    /// corner, first its maximum's.
    void (*bounds)(const Code& code, BoxBatch& boxes, Decision* decisions, void* scratch);

    /// Narrows `least` and `most` of boxes after `bounds`, by the value at the centre and the slopes (mean value
    /// theorem). Sharper than bounds of values where boxes are small: terms in x that cancel also cancel in the slope.
    void (*narrow)(const Code& code, BoxBatch& boxes, void* scratch);

    /// The first sign change of f along each of `count` segments.
    ///
    /// Nothing is assumed of f. Bounds of its values and slopes over shrinking intervals prove that it cannot change
    /// sign there, or that it must. A jump is a sign change; a pole is not, nor is a point where f is NaN. The result
    /// for a segment depends on that segment alone; many segments in one call fill the lanes best.
    void (*first_roots)(const Code& code, Segment* segments, std::size_t count, void* scratch);
};

BOB_DECLARE_KERNELS(FormulaKernels, formula_kernels)

/// The kernels for `count` segments or points at a time. A few leave the widest vectors mostly empty; narrower vectors
/// save a tenth of the time and give identical results.
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
