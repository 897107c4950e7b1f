#include "formula/dual.h"
#include "formula/evaluate.h"
#include "formula/mesh_lanes.h"

namespace bob::BOB_ISA {
namespace {

static_assert(lanes <= max_lanes);

/// Bits of the first `count` lanes.
inline M first_lanes(int count) {
    M mask{};
    for (int i = 0; i < lanes; ++i) mask[i] = i < count ? -1 : 0;
    return mask;
}
inline bool any(M mask) { return bits(mask) != 0; }

/// Runs the code on any kind of number: points, intervals, either with slopes. The results of decisions pass through
/// `decided(op, a, b, result)`.
template <class N, class Decided>
inline N run(const Code& code, const N& x, const N& y, const N& z, Domain& domain, void* scratch, Decided decided) {
    static_assert(sizeof(N) <= register_bytes);
    N* const registers = static_cast<N*>(scratch);
    registers[0] = x;
    registers[1] = y;
    registers[2] = z;
    for (const Instruction *i = code.instructions, *end = i + code.count; i != end; ++i) {
        const N &a = registers[i->a], &b = registers[i->b], &c = registers[i->c];
        N& out = registers[i->out];  // may be an operand's register
        if (i->op == affine) {
            out = scaled(a, i->scale, i->offset);
            watch(out, domain);
            continue;
        }
        if (i->op == corner_distance) {
            out = decided(i->op, a, b, corner(a, b));
            continue;
        }
        switch (i->op) {  // `continue` where numbers have a number, or the op itself tells the domain
            case Op::constant: set(out, i->offset); break;
            case Op::absolute: out = decided(i->op, a, a, abs(a)); continue;
            case Op::square: out = square(a); break;
            case Op::sqrt: out = sqrt(a, domain); continue;
            case Op::sin: out = sin(a, domain); continue;
            case Op::cos: out = cos(a, domain); continue;
            case Op::tan: out = tan(a); break;
            case Op::asin: out = asin(a, domain); continue;
            case Op::acos: out = acos(a, domain); continue;
            case Op::atan: out = atan(a); continue;
            case Op::exp: out = exp(a); break;
            case Op::log: out = log(a, domain); break;
            case Op::floor: out = decided(i->op, a, a, floor(a)); continue;
            case Op::ceil: out = decided(i->op, a, a, ceil(a)); continue;
            case Op::round: out = decided(i->op, a, a, round(a)); continue;
            case Op::power: out = power(a, static_cast<int>(i->scale)); break;
            case Op::add: out = a + b; break;
            case Op::subtract: out = a - b; break;
            case Op::multiply: out = a * b; break;
            case Op::divide: out = divide(a, b, domain); break;
            case Op::minimum: out = decided(i->op, a, b, minimum(a, b)); continue;
            case Op::maximum: out = decided(i->op, a, b, maximum(a, b)); continue;
            case Op::hypot: out = hypot(a, b); break;
            case Op::atan2: out = decided(i->op, a, b, atan2(a, b)); continue;
            case Op::modulo: out = modulo(a, b, domain); break;
            case Op::mesh_distance: out = mesh_distance(mesh_of(*i), a, b, c); break;
            case Op::select:
                domain.nowhere = M{};  // what is NaN so far may be what is not chosen
                out = decided(i->op, a, b, select(a, b, c));
                continue;
            default: break;
        }
        watch(out, domain);
    }
    return registers[code.result];
}

template <class N>
inline N run(const Code& code, const N& x, const N& y, const N& z, Domain& domain, void* scratch) {
    return run(code, x, y, z, domain, scratch, [](Op, const N&, const N&, const N& result) { return result; });
}

/// `count` floats and zeros after them.
inline F load_some(const float* p, int count) {
    F v{};
    for (int i = 0; i < count; ++i) v[i] = p[i];
    return v;
}
inline void store_some(float* p, F v, int count) {
    for (int i = 0; i < count; ++i) p[i] = v[i];
}

// Not inlined: a second copy of `run` for points makes compilers inline less elsewhere, and rays take 5 % longer.
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

void gradients(const Code& code, const float* const point[3], int count, float* value, float* const gradient[3],
               void* scratch) {
    using Gradient = Dual<F, 3>;
    const F one = constant(1.f);
    Domain domain;
    const Gradient f = run(code, Gradient{load_some(point[0], count), {one, F{}, F{}}},
                           Gradient{load_some(point[1], count), {F{}, one, F{}}},
                           Gradient{load_some(point[2], count), {F{}, F{}, one}}, domain, scratch);
    store_some(value, f.value, count);
    for (int axis = 0; axis < 3; ++axis) store_some(gradient[axis], f.slope[axis], count);
}

/// Writes down what intervals decide.
struct Record {
    Decision*& next;

    Interval operator()(Op op, const Interval& a, const Interval& b, const Interval& result) {
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
        switch (op) {
            case Op::minimum:
                d.first = bits(a.high < b.low);
                d.second = bits(b.high < a.low);
                break;
            case Op::maximum:
                d.first = bits(a.low > b.high);
                d.second = bits(b.low > a.high);
                break;
            case Op::select:
                d.first = bits(a.high < F{});
                d.second = bits(a.low >= F{});
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
                store(d.value, result.low + 0.f);  // of zeros, the positive one
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
    reach += 1e-6f * (reach + abs(middle));
    const F least = load<F>(boxes.least), most = load<F>(boxes.most);
    // False where the slopes or the value are unknown.
    const M smooth = ~domain.partly & (abs(middle) < constant(infinity));
    const M rises = smooth & (middle - reach > least), falls = smooth & (middle + reach < most);
    store(boxes.least, rises ? middle - reach : least);
    store(boxes.most, falls ? middle + reach : most);
    for (int axis = 0; axis < 3; ++axis) {
        store(boxes.least_slope[axis], smooth ? f.slope[axis].low : constant(not_a_number));
        store(boxes.most_slope[axis], smooth ? f.slope[axis].high : constant(not_a_number));
    }
}

/// Notes how soon along its ray each point comes to a jump: to where a select's condition is zero, a rounded number
/// passes a threshold, or an angle its cut, if these went on as straight as they are at the point.
struct JumpAhead {
    F& soonest;

    Dual<F, 1> operator()(Op op, const Dual<F, 1>& a, const Dual<F, 1>& b, const Dual<F, 1>& result) {
        if (op == Op::select || op == Op::atan2) {
            note(-a.value, a.slope[0]);
            if (op == Op::atan2) note(-b.value, b.slope[0]);
        } else if (is_rounding(op)) {
            const F up = result.value + (op == Op::floor ? 1.f : op == Op::ceil ? 0.f : 0.5f);
            note((a.slope[0] > F{} ? up : up - 1.f) - a.value, a.slope[0]);
        }
        return result;
    }

private:
    void note(F way, F speed) {
        const F t = way / speed;
        soonest = ((t >= F{}) & (t < soonest)) ? t : soonest;  // false for NaN
    }
};

bool has_jumps(const Code& code) {
    for (std::size_t i = 0; i < code.count; ++i) {
        if (may_jump(code.instructions[i].op)) return true;
    }
    return false;
}

/// Some rays, a lane each, and the formula along them.
struct Along {
    const Code& code;
    void* scratch;
    F origin[3], direction[3];

    [[nodiscard]] F value(F t) const {
        Domain domain;
        return run(code, origin[0] + t * direction[0], origin[1] + t * direction[1], origin[2] + t * direction[2],
                   domain, scratch);
    }
    [[nodiscard]] Dual<F, 1> with_slope(F t) const {
        F soonest;
        return with_slope(t, soonest);
    }
    /// And how far ahead the next jump is, as far as slopes show.
    [[nodiscard]] Dual<F, 1> with_slope(F t, F& soonest) const {
        Domain domain;
        Dual<F, 1> p[3];
        for (int axis = 0; axis < 3; ++axis) p[axis] = {origin[axis] + t * direction[axis], {direction[axis]}};
        soonest = constant(infinity);
        return run(code, p[0], p[1], p[2], domain, scratch, JumpAhead{soonest});
    }
    [[nodiscard]] Dual<Interval, 1> over(F from, F to, Domain& domain) const {
        Dual<Interval, 1> p[3];
        for (int axis = 0; axis < 3; ++axis) {
            const F a = origin[axis] + from * direction[axis], b = origin[axis] + to * direction[axis];
            p[axis] = {{min(a, b), max(a, b)}, {{direction[axis], direction[axis]}}};
        }
        return run(code, p[0], p[1], p[2], domain, scratch);
    }
};

/// A piece of each segment, and f at its ends, which lie on different sides.
struct Bracket {
    F a{}, fa{}, b{}, fb{};
};

/// The root in each bracket: Newton's steps, kept inside a bracket that closes around the root.
F refined(const Along& along, Bracket bracket, M wanted, F finest) {
    constexpr int max_steps = 40;
    F t = bracket.a - bracket.fa * (bracket.b - bracket.a) / (bracket.fb - bracket.fa);
    M open = wanted;
    const F close = finest * 0.0625f;
    for (int step = 0; step < max_steps; ++step) {
        const F middle = bracket.a + 0.5f * (bracket.b - bracket.a);
        // Every fourth step bisects, so that a bad slope can't stall the search.
        const M inside = (t > bracket.a) & (t < bracket.b) & all(step % 4 == 3 ? 0 : -1);
        t = open ? (inside ? t : middle) : t;
        const Dual<F, 1> f = along.with_slope(t);
        const M at_start = (f.value < F{}) == (bracket.fa < F{});  // the root is after t
        bracket.a = at_start ? t : bracket.a;
        bracket.b = at_start ? bracket.b : t;
        const F next = t - f.value / f.slope[0];
        open &= ~((abs(next - t) <= close) | (f.value == F{}) | (bracket.b - bracket.a <= close));
        if (!any(open)) break;
        t = open ? next : t;
    }
    return t;
}

/// Whether f, of different signs at two points close together, has a pole between them rather than a jump: farther out it
/// is much smaller, or NaN. (Closer by, floats may end before the growth shows.)
M grows(const Along& along, F a, F fa, F b, F fb) {
    const F out = 16.f * (b - a);
    return ~(abs(fa) + abs(fb) < 4.f * (abs(along.value(a - out)) + abs(along.value(b + out))));
}

/// The rays of `count` segments, at most `lanes`.
Along along_some(const Code& code, void* scratch, const Segment* const* segments, int count) {
    Along along{code, scratch, {}, {}};
    for (int lane = 0; lane < count; ++lane) {
        for (int axis = 0; axis < 3; ++axis) {
            along.origin[axis][lane] = segments[lane]->origin[axis];
            along.direction[axis][lane] = segments[lane]->direction[axis];
        }
    }
    return along;
}

/// Finds the roots that segments have between a and b.
void refine(const Code& code, void* scratch, Segment* const* segments, int count) {
    const Along along = along_some(code, scratch, segments, count);
    Bracket bracket;
    F finest{};
    for (int lane = 0; lane < count; ++lane) {
        const Segment& s = *segments[lane];
        bracket.a[lane] = s.a, bracket.fa[lane] = s.fa, bracket.b[lane] = s.b, bracket.fb[lane] = s.fb;
        finest[lane] = s.finest;
    }
    const F t = refined(along, bracket, first_lanes(count), finest);
    for (int lane = 0; lane < count; ++lane) segments[lane]->t = t[lane];
}

/// Whether a and b lie on different sides. Inside is below 0; comparisons with NaN are false, and a change to or from NaN
/// is none.
M on_different_sides(F a, F b) { return ((a < F{}) & (b >= F{})) | ((a >= F{}) & (b < F{})); }

/// How many segments are still searched, and how many have a root between their a and b.
struct Begun {
    int open = 0, bracketed = 0;
};

/// Prepares the search along `count` segments, at most `lanes`, and ends it where the values at both ends and the slopes
/// that are known settle a whole segment: 65 % of them in CSG, 77 in a tanglecube, 33 in prospero, none in smooth unions.
void begin(const Code& code, bool may_jump, Segment* segments, int count, void* scratch, Begun& begun) {
    F t_end{}, least{}, most{};
    const Segment* some[lanes];
    for (int lane = 0; lane < count; ++lane) {
        some[lane] = segments + lane;
        t_end[lane] = segments[lane].t_end;
        least[lane] = segments[lane].least_slope;
        most[lane] = segments[lane].most_slope;
    }
    F fa, fb{}, to_jump = constant(infinity);
    if (may_jump) {
        fa = along_some(code, scratch, some, count).with_slope(F{}, to_jump).value;
    } else if (2 * count <= lanes) {  // both ends of all at once
        F t{};
        for (int lane = 0; lane < count; ++lane) some[count + lane] = some[lane], t[count + lane] = t_end[lane];
        fa = along_some(code, scratch, some, 2 * count).value(t);
        for (int lane = 0; lane < count; ++lane) fb[lane] = fa[count + lane];
    } else {
        const Along along = along_some(code, scratch, some, count);
        fa = along.value(F{});
        fb = along.value(t_end);
    }
    const M known = may_jump ? M{} : first_lanes(count) & (abs(least) < constant(infinity)) & (abs(most) < constant(infinity));
    const M smooth = known & (abs(fa) < constant(infinity)) & (abs(fb) < constant(infinity));
    const M differ = on_different_sides(fa, fb), monotone = (least > F{}) | (most < F{});
    // Lines of the steepest slopes from both ends towards zero meet before it; by more than rounding moves them.
    const M inside = fa < F{};
    const F from_a = abs(fa) * (inside ? -least : most), from_b = abs(fb) * (inside ? most : -least);
    const M apart = from_a + from_b > 1.001f * (-least * most * t_end);
    const M crossing = smooth & differ & monotone, empty = smooth & ~differ & (monotone | apart);
    for (int lane = 0; lane < count; ++lane) {
        Segment& s = segments[lane];
        s.found = crossing[lane];
        s.unresolved = false;
        s.open = !(crossing[lane] | empty[lane]);
        s.a = 0, s.fa = fa[lane], s.b = t_end[lane], s.fb = fb[lane], s.to_jump = to_jump[lane];
        begun.open += s.open;
        begun.bracketed += s.found;
    }
}

/// Searches of segments, a lane each.
struct Searches {
    Along along;
    bool may_jump;
    F t_end{}, f_end{}, finest{};     // f_end: only where nothing jumps
    F a{}, fa{}, width{}, to_jump{};  // the next piece begins at a, and is no wider than this
    M stop_at_jump{}, pieces{}, active{}, unresolved{};
    Segment* segment[lanes] = {};

    void take(int lane, Segment& s) {
        for (int axis = 0; axis < 3; ++axis) {
            along.origin[axis][lane] = s.origin[axis];
            along.direction[axis][lane] = s.direction[axis];
        }
        t_end[lane] = width[lane] = s.t_end;
        f_end[lane] = s.fb;
        finest[lane] = s.finest;
        a[lane] = s.a, fa[lane] = s.fa, to_jump[lane] = s.to_jump;
        stop_at_jump[lane] = pieces[lane] = unresolved[lane] = 0;
        active[lane] = -1;
        segment[lane] = &s;
    }

    /// Looks at the next piece of each segment, and ends those that are settled; returns how many of them have a root.
    int step() {
        // Reasonable formulas need a few; after so many the ray is given up and reported.
        constexpr int max_pieces = 1024;
        // Where a wider piece would not do: up to just before the next jump, or, from there, to just behind it.
        const M at_jump = stop_at_jump & (to_jump <= finest);
        const F way = at_jump ? maximum(to_jump + 0.25f * finest, 0.5f * finest) : to_jump - 0.5f * finest;
        const F b = min(min(a + width, t_end), stop_at_jump ? a + way : t_end), length = b - a;
        Domain domain;
        const Dual<Interval, 1> f = along.over(a, b, domain);
        const Interval value = f.value, slope = f.slope[0];
        F jump_after_b = to_jump;
        const F fb = may_jump                       ? along.with_slope(b, jump_after_b).value
                     : any(active & (b != t_end)) ? along.value(b)
                                                  : f_end;
        const M differ = on_different_sides(fa, fb);

        // How soon f may reach zero at the steepest slope.
        const M smooth = ~(domain.partly | is_nan(slope.low) | is_nan(slope.high)) & (abs(fa) < constant(infinity));
        const F steepest = fa < F{} ? slope.high : -slope.low;
        const F reach = smooth ? (steepest > F{} ? abs(fa) / steepest : constant(infinity)) : F{};
        const M one_sided = (value.low >= F{}) | (value.high < F{}) | domain.nowhere | (reach > length);
        const M monotone = smooth & ((slope.low > F{}) | (slope.high < F{}));
        const M narrow = (min(width, length) <= finest) | at_jump;  // far out, b - a is not the width to the last bit
        M pole = narrow & ~(value.high - value.low < constant(infinity));
        if (any(active & pole & differ)) pole &= ~differ | grows(along, a, fa, b, fb);

        const M crossing = active & differ & (monotone | (narrow & ~pole));
        const M empty = active & ((~differ & (one_sided | monotone)) | pole);
        const M given_up = active & narrow & ~crossing & ~empty;
        unresolved |= given_up & ~at_jump;
        const M passed = empty | given_up, split = active & ~crossing & ~passed;
        pieces += 1;
        const M spent = active & ~crossing & (pieces >= all(max_pieces)) & ~(passed & (b >= t_end));
        unresolved |= spent;
        const M done = crossing | spent | (passed & (b >= t_end));
        if (any(done)) {
            for (unsigned left = bits(done); left; left &= left - 1) {
                const int lane = __builtin_ctz(left);
                Segment& s = *segment[lane];
                s.found = crossing[lane];
                s.unresolved = unresolved[lane];
                s.a = a[lane], s.fa = fa[lane], s.b = b[lane], s.fb = fb[lane];
            }
            active &= ~done;
        }
        // On past the piece, with a wider one; or to where f may be zero at the soonest, with a narrower one.
        const F skip = min(length - finest, 0.99f * reach);  // NaN, which skips nothing, where that is unknown
        M skips = split & (skip > 0.125f * length);
        if (any(skips)) {
            F jump_after_skip = to_jump;
            const F there = a + skip;
            const F f_there = may_jump ? along.with_slope(there, jump_after_skip).value : along.value(there);
            skips &= (f_there < F{}) == (fa < F{});  // rounding may see the soonest root later than it is
            a = skips ? there : a;
            fa = skips ? f_there : fa;
            to_jump = skips ? jump_after_skip : to_jump;
        }
        a = passed ? b : a;
        fa = passed ? fb : fa;
        to_jump = passed ? jump_after_b : to_jump;
        width = passed ? (at_jump ? t_end : width + width) : 0.5f * (b - a);
        // A jump much nearer than the piece is wide is one of many, which a bound over all of them may rule out.
        stop_at_jump = split ? (M)(to_jump > 0.0625f * width) : stop_at_jump & (to_jump <= finest);
        return __builtin_popcount(bits(crossing));
    }
};

/// Searches the segments that are open; returns how many of them have a root between their a and b.
int search(const Code& code, bool may_jump, Segment* next, const Segment* end, void* scratch) {
    // A lane that is done takes the next segment at once: few segments that need many pieces hold up no others.
    Searches searches{{code, scratch, {}, {}}, may_jump};
    int bracketed = 0;
    while (true) {
        for (unsigned idle = bits(~searches.active); idle; idle &= idle - 1) {
            while (next != end && !next->open) ++next;
            if (next == end) break;
            searches.take(__builtin_ctz(idle), *next++);
        }
        if (!any(searches.active)) return bracketed;
        bracketed += searches.step();
    }
}

void first_roots(const Code& code, Segment* segments, std::size_t count, void* scratch) {
    const bool may_jump = has_jumps(code);
    Segment* const end = segments + count;
    Begun begun;
    for (Segment* s = segments; s < end; s += lanes) {
        begin(code, may_jump, s, end - s < lanes ? static_cast<int>(end - s) : lanes, scratch, begun);
    }
    int bracketed = begun.bracketed;
    if (begun.open) bracketed += search(code, may_jump, segments, end, scratch);
    Segment* some[lanes];
    for (Segment* s = segments; bracketed; bracketed -= lanes) {
        int waiting = 0;
        for (; waiting < lanes && waiting < bracketed; ++s) {
            if (s->found) some[waiting++] = s;
        }
        refine(code, scratch, some, waiting);
        if (waiting < lanes) break;
    }
}

}  // namespace

const FormulaKernels formula_kernels = {lanes, values, colors, gradients, bounds, narrow, first_roots};

}  // namespace bob::BOB_ISA
