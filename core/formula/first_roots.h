/// First sign changes of a formula along ray segments. Only for *_kernels.cpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "formula/run.h"

// For sparse rays the code is mostly out of cache: separate functions cost them up to a quarter. In WebAssembly, larger
// code loads more slowly.
#ifdef __wasm__
#define BOB_INTO_SEARCH [[gnu::noinline]] inline
#else
#define BOB_INTO_SEARCH [[gnu::always_inline]] inline
#endif

namespace bob::BOB_ISA {

inline bool any(M mask) { return bits(mask) != 0; }

/// The distance along each ray to the next jump, extrapolated linearly from the point. A jump is a select's condition at
/// zero, a rounding threshold, or the cut of an angle.
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

/// One ray per lane, and the formula along it.
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
    /// Also returns in `soonest` the distance to the next jump, estimated from slopes.
    [[nodiscard]] Dual<F, 1> with_slope(F t, F& soonest) const {
        Domain domain;
        Dual<F, 1> p[3];
        for (int axis = 0; axis < 3; ++axis) p[axis] = {origin[axis] + t * direction[axis], {direction[axis]}};
        soonest = constant(infinity);
        return run(code, p[0], p[1], p[2], domain, scratch, JumpAhead{soonest});
    }
    /// f and, if it may jump, the distance to the next jump.
    [[nodiscard]] F value(F t, F& soonest) const {
        if (code.may_jump) return with_slope(t, soonest).value;
        soonest = constant(infinity);
        return value(t);
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

/// An interval of each segment, with f of different sign at its ends.
struct Bracket {
    F a{}, fa{}, b{}, fb{};
};

/// Finds the root in each bracket: Newton's steps, safeguarded by a shrinking bracket.
inline F refined(const Along& along, Bracket bracket, M wanted, F finest) {
    constexpr int max_steps = 40;
    F t = bracket.a - bracket.fa * (bracket.b - bracket.a) / (bracket.fb - bracket.fa);
    M open = wanted;
    const F close = finest * 0.0625f;
    for (int step = 0; step < max_steps; ++step) {
        const F middle = bracket.a + 0.5f * (bracket.b - bracket.a);
        // Every fourth step bisects, so that a bad slope cannot stall the search.
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

/// Whether f, of different signs at two close points, has a pole between them and not a jump. Farther out it is much
/// smaller, or NaN. (Closer in, floats may be too coarse to show the growth.)
inline M grows(const Along& along, F a, F fa, F b, F fb) {
    const F out = 16.f * (b - a);
    return ~(abs(fa) + abs(fb) < 4.f * (abs(along.value(a - out)) + abs(along.value(b + out))));
}

/// 1 to `lanes` segments as columns; unused lanes repeat the first.
struct SegmentColumns {
    enum { origin = 0, direction = 3, t_end = 6, finest, least_slope, most_slope, a, fa, b, fb, inner, count = inner + 2 };
    static_assert(offsetof(Segment, inner) == inner * sizeof(float));

    F of[count];

    SegmentColumns(const Segment* const* segments, int count) {
        const float* rows[lanes];
        for (int lane = 0; lane < lanes; ++lane) rows[lane] = reinterpret_cast<const float*>(segments[lane < count ? lane : 0]);
        load_rows(rows, of);
    }

    const F& operator[](int column) const { return of[column]; }
    [[nodiscard]] Along along(const Code& code, void* scratch) const {
        return {code, scratch, {of[origin], of[origin + 1], of[origin + 2]}, {of[direction], of[direction + 1], of[direction + 2]}};
    }
};

/// Finds the roots of segments between a and b.
BOB_INTO_SEARCH void refine(const Code& code, void* scratch, Segment* const* segments, int count) {
    const SegmentColumns s(segments, count);
    const F t = refined(s.along(code, scratch), {s[s.a], s[s.fa], s[s.b], s[s.fb]}, first_lanes(count), s[s.finest]);
    for (int lane = 0; lane < count; ++lane) segments[lane]->t = t[lane];
}

/// Whether a and b lie on different sides. Inside is below 0; comparisons with NaN are false, so a change to or from
/// NaN is no sign change.
inline M on_different_sides(F a, F b) { return ((a < F{}) & (b >= F{})) | ((a >= F{}) & (b < F{})); }

/// Whether f, given bounds of its slopes, keeps the sign of both ends of an interval. Either it is monotonic, or the
/// steepest lines from both ends towards zero meet before it, by more than rounding errors.
inline M stays(F fa, F fb, F least, F most, F length) {
    const M inside = fa < F{};
    const F from_a = abs(fa) * (inside ? -least : most), from_b = abs(fb) * (inside ? most : -least);
    const M finite = (abs(fa) < constant(infinity)) & (abs(fb) < constant(infinity));
    const M one_way = (least >= F{}) | (most <= F{}), apart = from_a + from_b > 1.001f * (-least * most * length);
    return finite & ~on_different_sides(fa, fb) & (apart | one_way);
}

/// Whether bounds prove that f has one sign.
inline M is_one_sided(Interval value, const Domain& domain) { return (value.low >= F{}) | (value.high < F{}) | domain.nowhere; }

/// f at n places along each of `count` segments, all at once; at most `lanes` places together. Not inlined, as copies
/// of `run` for points in formula_kernels.cpp.
template <int n>
[[gnu::noinline]] void values_at_once(const Code& code, void* scratch, const Segment* const* segments, int count, const F (&t)[n], F (&f)[n]) {
    const Segment* at[lanes];
    F places{};
    for (int k = 0; k < n; ++k) {
        for (int i = 0; i < count; ++i) at[k * count + i] = segments[i], places[k * count + i] = t[k][i];
    }
    const F values = SegmentColumns(at, n * count).along(code, scratch).value(places);
    for (int k = 0; k < n; ++k) {
        for (int i = 0; i < count; ++i) f[k][i] = values[k * count + i];
    }
}

/// The same at any number of places.
template <int n>
void values_along(const Code& code, void* scratch, const Segment* const* segments, int count, const F (&t)[n], F (&f)[n]) {
    if (n * count <= lanes) return values_at_once(code, scratch, segments, count, t, f);
    const Along along = SegmentColumns(segments, count).along(code, scratch);
    for (int k = 0; k < n; ++k) f[k] = along.value(t[k]);
}

/// Number of parts of a segment that is not settled as a whole. Bounds over small parts decide more than one over the
/// whole, and parts of one segment fill lanes where few rays pass a cell. With 2, 5 % of prospero's rays take a tenth
/// longer; with 4, all of them a twentieth.
constexpr int parts_of_segment = 3;

/// Places at the ends of the parts. If all places of the segments fit a vector, f is computed at all of them together.
constexpr int places = parts_of_segment + 1;

/// Where a segment is cut into parts, from 0 to its end.
template <class T>
inline T cut_at(T t_end, int k, int parts = parts_of_segment) {
    return t_end * (static_cast<float>(k) / static_cast<float>(parts));
}

/// f at both ends of a few segments, and at the places where they may be cut.
[[gnu::noinline]] inline void begin_few(const Code& code, Segment* const* segments, int count, F t_end, F (&ends)[2], void* scratch) {
    F t[places], f[places] = {};
    for (int k = 0; k < places; ++k) t[k] = cut_at(t_end, k);
    values_at_once(code, scratch, segments, count, t, f);
    ends[0] = f[0], ends[1] = f[parts_of_segment];
    for (int lane = 0; lane < count; ++lane) {
        for (int k = 1; k < parts_of_segment; ++k) segments[lane]->inner[k - 1] = f[k][lane];
    }
}

/// Prepares the search along at most `lanes` segments. End values and slopes settle many segments as a whole: 65 % in
/// CSG, 77 in a tanglecube, 33 in prospero.
inline void begin(const Code& code, Segment* const* segments, int count, bool are_few, void* scratch) {
    const SegmentColumns columns(segments, count);
    const F t_end = columns[SegmentColumns::t_end], least = columns[SegmentColumns::least_slope], most = columns[SegmentColumns::most_slope];
    F ends[2] = {};
    auto& [fa, fb] = ends;
    if (are_few) {
        begin_few(code, segments, count, t_end, ends, scratch);
    } else {
        values_along(code, scratch, segments, count, {F{}, t_end}, ends);
    }
    const M finite = (abs(fa) < constant(infinity)) & (abs(fb) < constant(infinity));
    const M differ = on_different_sides(fa, fb), monotone = (least > F{}) | (most < F{});
    const M crossing = finite & differ & monotone;
    const M empty = stays(fa, fb, least, most, t_end);
    for (int lane = 0; lane < count; ++lane) {
        Segment& s = *segments[lane];
        s.found = crossing[lane];
        s.open = !(crossing[lane] | empty[lane]);
        s.a = 0, s.fa = fa[lane], s.b = t_end[lane], s.fb = fb[lane];
        s.doubt = infinity;
    }
}

/// A part of a segment that is searched separately, with f at its ends.
struct SegmentPart {
    Segment* segment;
    float a, fa, b, fb;
    float to_jump;  // distance from a
    float start;    // initial a
    float width;    // maximum width of the next interval
    bool stop_at_jump;  // no default values: they would be written to hundreds of unused parts
};

/// Cuts at most `lanes` open segments into parts, and omits the parts that slopes settle. A part with different signs
/// at its ends makes the parts after it unnecessary, unless it holds a pole: then the search continues from the
/// segment's a.
inline SegmentPart* cut(const Code& code, Segment* const* segments, int count, bool are_few, SegmentPart* parts, void* scratch) {
    const SegmentColumns columns(segments, count);
    const F least = columns[SegmentColumns::least_slope], most = columns[SegmentColumns::most_slope];
    F t[places], f[places];
    t[0] = columns[SegmentColumns::a], f[0] = columns[SegmentColumns::fa];
    t[parts_of_segment] = columns[SegmentColumns::b], f[parts_of_segment] = columns[SegmentColumns::fb];
    for (int k = 1; k < parts_of_segment; ++k) t[k] = cut_at(t[parts_of_segment], k);
    if (are_few) {
        for (int k = 1; k < parts_of_segment; ++k) f[k] = columns[SegmentColumns::inner + k - 1];
    } else {
        F inner[parts_of_segment - 1], f_inner[parts_of_segment - 1] = {};
        for (int k = 1; k < parts_of_segment; ++k) inner[k - 1] = t[k];
        values_along(code, scratch, segments, count, inner, f_inner);
        for (int k = 1; k < parts_of_segment; ++k) f[k] = f_inner[k - 1];
    }
    M empty[parts_of_segment], differ[parts_of_segment];
    for (int k = 0; k < parts_of_segment; ++k) {
        empty[k] = stays(f[k], f[k + 1], least, most, t[k + 1] - t[k]);
        differ[k] = on_different_sides(f[k], f[k + 1]);
    }
    for (int lane = 0; lane < count; ++lane) {
        Segment& s = *segments[lane];
        s.a = s.b;
        for (int k = 0; k < parts_of_segment; ++k) {
            if (!empty[k][lane]) *parts++ = {&s, t[k][lane], f[k][lane], t[k + 1][lane], f[k + 1][lane], infinity, t[k][lane], t[k + 1][lane] - t[k][lane], false};
            if (!differ[k][lane]) continue;
            s.a = t[k + 1][lane], s.fa = f[k + 1][lane];
            break;
        }
    }
    return parts;
}

/// Searches of parts, one per lane.
struct Searches {
    Along along;
    F t_end{}, f_end{}, finest{};
    F a{}, fa{}, width{}, to_jump{};  // the next interval begins at a; `width` is its maximum width
    M stop_at_jump{}, pieces{}, active{}, unresolved{};
    const SegmentPart* part[lanes];  // valid in active lanes

    explicit Searches(const Along& nowhere) : along(nowhere) {}

    BOB_INTO_SEARCH void take(int lane, const SegmentPart& next) {
        const Segment& s = *next.segment;
        for (int axis = 0; axis < 3; ++axis) {
            along.origin[axis][lane] = s.origin[axis];
            along.direction[axis][lane] = s.direction[axis];
        }
        t_end[lane] = next.b, width[lane] = next.width;
        f_end[lane] = next.fb;
        finest[lane] = s.finest;
        a[lane] = next.a, fa[lane] = next.fa, to_jump[lane] = next.to_jump;
        stop_at_jump[lane] = next.stop_at_jump ? -1 : 0;
        pieces[lane] = unresolved[lane] = 0;
        active[lane] = -1;
        part[lane] = &next;
    }

    /// The remainder of a lane's part.
    [[nodiscard]] SegmentPart rest(int lane) const {
        SegmentPart rest = *part[lane];
        rest.a = a[lane], rest.fa = fa[lane], rest.to_jump = to_jump[lane], rest.width = width[lane];
        rest.stop_at_jump = stop_at_jump[lane];
        return rest;
    }

    /// Stores a lane's root, or the place where it is unresolved.
    void finish(int lane, bool crossing, F b, F fb) {
        Segment& s = *part[lane]->segment;
        if (unresolved[lane] && part[lane]->start < s.doubt) s.doubt = part[lane]->start;
        if (!crossing || (s.found && s.a <= a[lane])) return;
        s.found = true;
        s.a = a[lane], s.fa = fa[lane], s.b = b[lane], s.fb = fb[lane];
    }

    /// Bounds f over the next interval of each part, and ends the settled ones.
    [[gnu::noinline]] void step() {
        // Near a jump: first to just before it, then to just behind it.
        const M at_jump = stop_at_jump & (to_jump <= finest);
        const F way = at_jump ? maximum(to_jump + 0.25f * finest, 0.5f * finest) : to_jump - 0.5f * finest;
        const F b = min(min(a + width, t_end), stop_at_jump ? a + way : t_end);
        Domain domain;
        const Dual<Interval, 1> f = along.over(a, b, domain);
        F jump_after_b = to_jump;
        const F fb = any(active & (b != t_end)) ? along.value(b, jump_after_b) : f_end;
        judge(b, f, domain, fb, jump_after_b, at_jump);
    }

    /// Ends the parts settled by f over their next intervals and at these intervals' ends, b.
    BOB_INTO_SEARCH void judge(F b, const Dual<Interval, 1>& f, const Domain& domain, F fb, F jump_after_b, M at_jump) {
        // Reasonable formulas need a few; beyond this limit the ray is abandoned and reported.
        constexpr int max_pieces = 1024;
        const Interval value = f.value, slope = f.slope[0];
        const F length = b - a;
        const M differ = on_different_sides(fa, fb);

        // The nearest possible zero of f at the steepest slope.
        const M smooth = ~(domain.partly | is_nan(slope.low) | is_nan(slope.high)) & (abs(fa) < constant(infinity));
        const F steepest = fa < F{} ? slope.high : -slope.low;
        const F reach = smooth ? (steepest > F{} ? abs(fa) / steepest : constant(infinity)) : F{};
        const M one_sided = is_one_sided(value, domain);
        const M monotone = smooth & ((slope.low > F{}) | (slope.high < F{}));
        const M narrow = (min(width, length) <= finest) | at_jump;  // far out, b - a is not the width to the last bit
        M pole = narrow & ~(value.high - value.low < constant(infinity));
        if (any(active & pole & differ)) pole &= ~differ | grows(along, a, fa, b, fb);

        const M crossing = active & differ & (monotone | (narrow & ~pole));
        const M settled = one_sided | (smooth & stays(fa, fb, slope.low, slope.high, length));
        const M empty = active & ((~differ & settled) | pole);
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
                finish(lane, crossing[lane], b, fb);
            }
            active &= ~done;
        }
        // Advances past the interval and widens it, or advances to the nearest possible zero and narrows it.
        const F skip = min(length - finest, 0.99f * reach);  // NaN, which skips nothing, if unknown
        M skips = split & (skip > 0.125f * length);
        if (any(skips)) {
            F jump_after_skip = to_jump;
            const F there = a + skip;
            const F f_there = along.value(there, jump_after_skip);
            skips &= (f_there < F{}) == (fa < F{});  // rounding may compute the nearest zero too late
            a = skips ? there : a;
            fa = skips ? f_there : fa;
            to_jump = skips ? jump_after_skip : to_jump;
        }
        a = passed ? b : a;
        fa = passed ? fb : fa;
        to_jump = passed ? jump_after_b : to_jump;
        width = passed ? (at_jump ? t_end : width + width) : 0.5f * (b - a);
        // A jump much nearer than the interval's width is one of many. A bound over all of them may rule them out.
        stop_at_jump = split ? (M)(to_jump > 0.0625f * width) : stop_at_jump & (to_jump <= finest);
    }
};

BOB_INTO_SEARCH void search(const Code& code, const SegmentPart* next, const SegmentPart* end, void* scratch) {
    // A finished lane takes the next part at once, so that parts with many intervals do not hold up others.
    Searches searches({code, scratch, {}, {}});
    while (true) {
        for (unsigned idle = bits(~searches.active); idle && next != end; idle &= idle - 1) {
            searches.take(__builtin_ctz(idle), *next++);
        }
        if (!any(searches.active)) return;
        searches.step();
    }
}

constexpr int most_searched = 256;

/// Searches the open ones among at most `most_searched` segments, part by part.
BOB_INTO_SEARCH void search_open(const Code& code, Segment* const* segments, int count, bool are_few, void* scratch) {
    Segment* open[most_searched];
    int left = 0;
    for (int i = 0; i < count; ++i) {
        if (segments[i]->open) open[left++] = segments[i];
    }
    if (!left) return;
    SegmentPart parts[most_searched * parts_of_segment], *end = parts;
    for (int i = 0; i < left; i += lanes) end = cut(code, open + i, left - i < lanes ? left - i : lanes, are_few, end, scratch);
    search(code, parts, end, scratch);
    end = parts;
    for (int i = 0; i < left; ++i) {
        Segment& s = *open[i];
        if (!s.found && s.a < s.b) *end++ = {&s, s.a, s.fa, s.b, s.fb, infinity, s.a, s.b - s.a, false};
    }
    if (end != parts) search(code, parts, end, scratch);
}

/// Searches at most `most_searched` segments with known slopes, starting from the values at their ends.
BOB_INTO_SEARCH void search_from_ends(const Code& code, Segment* const* segments, int count, void* scratch) {
    const bool are_few = places * count <= lanes;
    for (int i = 0; i < count; i += lanes) begin(code, segments + i, count - i < lanes ? count - i : lanes, are_few, scratch);
    search_open(code, segments, count, are_few, scratch);
}

/// A part with bounds of f.
struct BoundedPart {
    Segment* segment;
    float a, b;
    float least, most, least_slope, most_slope;
    bool partly;
};

/// The parts of segments, `parts_of_each` per segment, that may contain a sign change.
inline BoundedPart* bounded_parts(const Code& code, Segment* const* segments, int count, int parts_of_each, BoundedPart* parts, void* scratch) {
    for (int in_all = count * parts_of_each, number = 0; in_all > 0; in_all -= lanes) {
        const int some = in_all < lanes ? in_all : lanes;
        Segment* at[lanes];
        F from{}, to{};
        for (int lane = 0; lane < some; ++lane) {
            at[lane] = *segments;
            from[lane] = cut_at(at[lane]->t_end, number, parts_of_each), to[lane] = cut_at(at[lane]->t_end, number + 1, parts_of_each);
            if (++number == parts_of_each) ++segments, number = 0;
        }
        Domain domain;
        const Dual<Interval, 1> f = SegmentColumns(at, some).along(code, scratch).over(from, to, domain);
        for (unsigned open = bits(first_lanes(some) & ~is_one_sided(f.value, domain)); open; open &= open - 1) {
            const int lane = __builtin_ctz(open);
            *parts++ = {at[lane], from[lane], to[lane], f.value.low[lane], f.value.high[lane],
                        f.slope[0].low[lane], f.slope[0].high[lane], domain.partly[lane] != 0};
        }
    }
    return parts;
}

/// Ends the parts, at most `lanes`, that bounds and end values settle. Appends the remainders of the others to `left`
/// or, if they are whole segments, marks them open.
inline SegmentPart* settle(const Code& code, const BoundedPart* parts, int count, SegmentPart* left, void* scratch) {
    const Segment* segments[lanes];
    F a{}, b{};
    Dual<Interval, 1> f{};
    Domain domain;
    for (int lane = 0; lane < count; ++lane) {
        const BoundedPart& part = parts[lane];
        segments[lane] = part.segment;
        a[lane] = part.a, b[lane] = part.b;
        f.value.low[lane] = part.least, f.value.high[lane] = part.most;
        f.slope[0].low[lane] = part.least_slope, f.slope[0].high[lane] = part.most_slope;
        domain.partly[lane] = part.partly ? -1 : 0;
    }
    Searches searches(SegmentColumns(segments, count).along(code, scratch));
    F to_jump;
    const F fa = searches.along.value(a, to_jump), fb = searches.along.value(b);
    SegmentPart whole[lanes];
    for (int lane = 0; lane < count; ++lane) {
        whole[lane] = {parts[lane].segment, a[lane], fa[lane], b[lane], fb[lane], to_jump[lane], a[lane], b[lane] - a[lane], false};
        searches.take(lane, whole[lane]);
    }
    searches.judge(b, f, domain, fb, to_jump, M{});
    for (unsigned open = bits(searches.active); open; open &= open - 1) {
        const int lane = __builtin_ctz(open);
        if (code.may_jump) {
            *left++ = searches.rest(lane);
        } else {
            Segment& s = *parts[lane].segment;
            s.open = true;
            s.a = a[lane], s.fa = fa[lane], s.b = b[lane], s.fb = fb[lane];
        }
    }
    return left;
}

/// Searches at most `most_searched` segments without known slopes, starting from bounds. End values would not settle
/// any of them; bounds settle two thirds and save most end values. If f may jump, bounds of parts are better: otherwise
/// 5 % of the rays through a knob take half as long again. If not, bounds of the whole are better: parts cost all rays
/// of smooth unions two fifths.
[[gnu::noinline]] inline void search_from_bounds(const Code& code, Segment* const* segments, int count, void* scratch) {
    BoundedPart bounded[most_searched * parts_of_segment];
    SegmentPart left[most_searched * parts_of_segment], *end = left;
    for (int i = 0; i < count; ++i) segments[i]->found = segments[i]->open = false, segments[i]->doubt = infinity;
    const BoundedPart* const last = bounded_parts(code, segments, count, code.may_jump ? parts_of_segment : 1, bounded, scratch);
    for (const BoundedPart* part = bounded; part < last; part += lanes) {
        end = settle(code, part, last - part < lanes ? static_cast<int>(last - part) : lanes, end, scratch);
    }
    // Parts behind a root are not needed.
    end = std::remove_if(left, end, [](const SegmentPart& part) { return part.segment->found && part.segment->a < part.start; });
    if (end != left) search(code, left, end, scratch);
    if (!code.may_jump) search_open(code, segments, count, false, scratch);
}

inline void first_roots(const Code& code, Segment* segments, std::size_t count, void* scratch) {
    for (Segment *s = segments, *const end = segments + count; s < end;) {
        Segment *with_slopes[most_searched], *without[most_searched], *bracketed[most_searched];
        int known = 0, unknown = 0, found = 0;
        Segment *const first = s, *const last = end - s < most_searched ? end : s + most_searched;
        for (; s < last; ++s) {
            const bool is_known = std::abs(s->least_slope) < infinity && std::abs(s->most_slope) < infinity;
            (is_known ? with_slopes[known++] : without[unknown++]) = s;
        }
        if (known) search_from_ends(code, with_slopes, known, scratch);
        if (unknown) search_from_bounds(code, without, unknown, scratch);
        for (Segment* each = first; each < last; ++each) {
            each->unresolved = each->doubt < (each->found ? each->b : infinity);
            if (each->found) bracketed[found++] = each;
        }
        for (int i = 0; i < found; i += lanes) refine(code, scratch, bracketed + i, found - i < lanes ? found - i : lanes);
    }
}

}  // namespace bob::BOB_ISA
