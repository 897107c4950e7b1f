#include "formula/first_roots.h"

namespace bob::BOB_ISA {
namespace {

static_assert(lanes <= max_lanes);

/// Loads `count` floats, padded with zeros.
inline F load_some(const float* p, int count) {
    F v{};
    for (int i = 0; i < count; ++i) v[i] = p[i];
    return v;
}
inline void store_some(float* p, F v, int count) {
    for (int i = 0; i < count; ++i) p[i] = v[i];
}

// Not inlined: with a second copy of `run` for points compilers inline less elsewhere, and rays take 5 % longer.
[[gnu::noinline]] void values(const Code& code, const float* const point[3], int count, float* value, void* scratch) {
    Domain domain;
    store_some(value, run(code, load_some(point[0], count), load_some(point[1], count), load_some(point[2], count),
                          domain, scratch), count);
}

void colors(const Code& code, const int results[3], const float* const point[3], int count, float* const color[3], void* scratch) {
    float red[lanes];
    values(code, point, count, red, scratch);
    for (int i = 0; i < 3; ++i) store_some(color[i], static_cast<const F*>(scratch)[results[i]], count);
}

/// The nearest jump of a formula within `reach` of each point, and the gradient of its cause. The cause is a select's
/// condition, a rounded value, an angle's cut, or a quotient's divisor that passes zero. Distances are linear estimates
/// from slopes.
struct JumpBeside {
    using Gradient = Dual<F, 3>;

    F distance = constant(reach);
    F across[3] = {};

    Gradient operator()(Op op, const Gradient& a, const Gradient& b, const Gradient& result) {
        if (op == Op::select) {
            note(a.value, a);
        } else if (op == Op::atan2) {
            note(b.value < F{} ? a.value : constant(infinity), a);
        } else if (op == Op::divide) {
            note(b.value, b);
        } else if (op == Op::tan) {
            note(1.f / result.value, a);
        } else if (is_rounding(op)) {
            const float shift = op == Op::round ? 0.5f : 0.f;
            note(a.value - shift - round(a.value - shift), a);
        }
        return result;
    }

    /// Whether f, not zero near a point where it changes its sign, jumps there.
    [[nodiscard]] M instead_of(const Gradient& f) const {
        return (distance < constant(reach)) & ~(abs(f.value) < reach * length(f.slope));
    }

private:
    static constexpr float reach = 1e-5f;  // roots are accurate to about 1e-6

    static F length(const F (&v)[3]) { return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

    void note(F value, const Gradient& of) {
        const F size = length(of.slope), away = abs(value) / size;
        const M nearer = (away < distance) & (size < constant(infinity));  // false for NaN
        distance = nearer ? away : distance;
        for (int axis = 0; axis < 3; ++axis) across[axis] = nearer ? of.slope[axis] : across[axis];
    }
};

void gradients(const Code& code, const float* const point[3], int count, bool across_jumps, float* value, float* const gradient[3],
               void* scratch) {
    using Gradient = Dual<F, 3>;
    const F one = constant(1.f);
    Domain domain;
    JumpBeside beside;
    const Gradient f = run(code, Gradient{load_some(point[0], count), {one, F{}, F{}}},
                           Gradient{load_some(point[1], count), {F{}, one, F{}}},
                           Gradient{load_some(point[2], count), {F{}, F{}, one}}, domain, scratch,
                           [&](Op op, const Gradient& a, const Gradient& b, const Gradient& result) { return beside(op, a, b, result); });
    const M jumps = across_jumps ? beside.instead_of(f) : M{};
    store_some(value, f.value, count);
    for (int axis = 0; axis < 3; ++axis) store_some(gradient[axis], jumps ? beside.across[axis] : f.slope[axis], count);
}

/// Stores the decisions of intervals.
struct Record {
    Decision*& next;

    Interval operator()(Op op, const Interval& a, const Interval& b, const Interval& result) {
        if (op == Op::divide || op == Op::tan) return result;
        Decision& d = *next++;
        if (op == corner_distance) {
            const M inside = (a.high < F{}) | (b.high < F{});
            d.first = bits(inside & (a.low > b.high));
            d.second = bits(inside & (b.low > a.high));
            Decision& which = *next++;
            which.first = bits(inside);
            which.second = bits((a.low >= F{}) & (b.low >= F{}));
            return result;
        }
        if (is_select(op)) {
            d.first = bits(a.high < F{});
            d.second = bits(a.low >= F{});
            return result;
        }
        switch (op) {
            case Op::minimum:
                d.first = bits(a.high < b.low);
                d.second = bits(b.high < a.low);
                break;
            case Op::maximum:
                d.first = bits(a.low > b.high);
                d.second = bits(b.low > a.high);
                break;
            case Op::absolute:
                d.first = bits(a.low >= F{});
                d.second = bits(a.high < F{});
                break;
            case Op::atan2:
                d.first = bits(crosses_cut(a, b) & (b.high < F{}));
                d.second = 0;
                break;
            default:
                d.first = bits(result.low == result.high);
                d.second = bits(result.low + 1.f == result.high);
                store(d.value, result.low + 0.f);  // turns -0 into 0
                break;
        }
        return result;
    }
};

void bounds(const Code& code, BoxBatch& boxes, Decision* decisions, void* scratch) {
    Domain domain;
    Interval p[3];
    for (int axis = 0; axis < 3; ++axis) p[axis] = {load<F>(boxes.low[axis]), load<F>(boxes.high[axis])};
    const Interval f = run(code, p[0], p[1], p[2], domain, scratch, Record{decisions});
    store(boxes.least, f.low);
    store(boxes.most, f.high);
    boxes.partly = bits(domain.partly);
    boxes.nowhere = bits(domain.nowhere);
}

void narrow(const Code& code, BoxBatch& boxes, void* scratch) {
    using Slopes = Dual<Interval, 3>;
    const Interval none = interval(0), one = interval(1);
    Interval p[3];
    F center[3], half[3];
    for (int axis = 0; axis < 3; ++axis) {
        p[axis] = {load<F>(boxes.low[axis]), load<F>(boxes.high[axis])};
        center[axis] = 0.5f * (p[axis].low + p[axis].high);
        half[axis] = maximum(p[axis].high - center[axis], center[axis] - p[axis].low);
    }
    Domain domain, at_center;
    const Slopes f = run(code, Slopes{p[0], {one, none, none}}, Slopes{p[1], {none, one, none}},
                         Slopes{p[2], {none, none, one}}, domain, scratch);
    const F middle = run(code, center[0], center[1], center[2], at_center, scratch);
    F reach{};
    for (int axis = 0; axis < 3; ++axis) {
        reach += maximum(abs(f.slope[axis].low), abs(f.slope[axis].high)) * half[axis];
    }
    // Slopes are ignored if they allow far more than bounds of the values, as in sums of exponentials.
    const M tell = ~(reach > 4.f * (f.value.high - f.value.low));
    reach += 1e-6f * (reach + abs(middle));
    const F least = load<F>(boxes.least), most = load<F>(boxes.most);
    // False if the slopes or the value are unknown.
    const M smooth = ~domain.partly & (abs(middle) < constant(infinity));
    const M rises = smooth & (middle - reach > least), falls = smooth & (middle + reach < most);
    store(boxes.least, rises ? middle - reach : least);
    store(boxes.most, falls ? middle + reach : most);
    const M known = smooth & tell;
    for (int axis = 0; axis < 3; ++axis) {
        store(boxes.least_slope[axis], known ? f.slope[axis].low : constant(not_a_number));
        store(boxes.most_slope[axis], known ? f.slope[axis].high : constant(not_a_number));
    }
}

}  // namespace

const FormulaKernels formula_kernels = {lanes, values, colors, gradients, bounds, narrow, first_roots};

}  // namespace bob::BOB_ISA
