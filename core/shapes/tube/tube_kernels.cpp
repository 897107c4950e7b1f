#include <limits>

#include "shapes/bvh_traversal.h"
#include "shapes/tube/tube_pieces.h"

/// Intersection of a ray with a piece.
///
/// In units of length along the ray, the ray is inside the ball at s from a(s) - sqrt(q(s)) to a(s) + sqrt(q(s)). Here
/// a is the centre's coordinate along the ray, and q = r^2 - x^2 - y^2, from the radius and the centre's coordinates
/// across the ray.
///
/// Where q >= 0 on an interval of s, these segments move continuously, so that their union is one segment, from the
/// minimum of a - sqrt(q) to the maximum of a + sqrt(q): a *span*. The union of all balls is the union of the spans of
/// all pieces, for any radius and curvature, from outside and from inside.
///
/// So there are two problems. One is where q >= 0, a polynomial of degree 6. The other is the minimum of f = a -
/// sqrt(q) there (for the other end, the minimum of f with -a for a). Where f' = 0, 2 f'' sqrt(q) is k = 2 a'' sqrt(q)
/// + 2 a'^2 - q''. In tubes thinner than the curve's radius of curvature, bounds of k usually prove that it is positive
/// on the whole piece: then f has at most one critical point, a minimum. Pieces with an undecided sign of k are halved.
namespace bob::BOB_ISA {
namespace {

using D4 [[gnu::vector_size(32)]] = double;

inline double smaller(double a, double b) { return a < b ? a : b; }
inline double larger(double a, double b) { return a > b ? a : b; }
inline D4 smaller(D4 a, D4 b) { return a < b ? a : b; }
inline D4 larger(D4 a, D4 b) { return a > b ? a : b; }
inline double root(double x) { return __builtin_sqrt(larger(x, 0)); }

/// Bernstein coefficients below and above a place, 0..1, of their interval (de Casteljau).
template <int N>
inline void split(const double (&p)[N], double at, double (&low)[N], double (&high)[N]) {
    for (int i = 0; i < N; ++i) high[i] = p[i];
    for (int i = 0; i < N; ++i) {
        low[i] = high[0];
        for (int j = 0; j + 1 < N - i; ++j) high[j] += at * (high[j + 1] - high[j]);
    }
}

template <int N>
inline double least(const double (&p)[N]) {
    double result = p[0];
    for (int i = 1; i < N; ++i) result = smaller(result, p[i]);
    return result;
}

template <int N>
inline double greatest(const double (&p)[N]) {
    double result = p[0];
    for (int i = 1; i < N; ++i) result = larger(result, p[i]);
    return result;
}

/// Coefficients of a and q in Bernstein form, on an interval of the piece.
struct Bernstein {
    double a[4], q[7];

    /// A lower bound of f.
    [[nodiscard]] double bound() const { return least(a) - root(greatest(q)); }
};

/// A ray's axes: along it, and two across.
struct RayFrame {
    D4 column[3], origin;  // the coordinates (along, across, across, 0) of x, y, z, and of the ray's origin
    double scale;          // the length of its direction

    explicit RayFrame(const Ray& ray) {
        const double dx = ray.direction.x, dy = ray.direction.y, dz = ray.direction.z;
        scale = __builtin_sqrt(dx * dx + dy * dy + dz * dz);
        const double x = dx / scale, y = dy / scale, z = dz / scale;
        // Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017.
        const double sign = z < 0 ? -1 : 1;
        const double a = -1 / (sign + z), b = x * y * a;
        column[0] = D4{x, 1 + sign * x * x * a, b, 0};
        column[1] = D4{y, sign * b, sign + y * y * a, 0};
        column[2] = D4{z, -sign * x, -y, 0};
        origin = ray.origin.x * column[0] + ray.origin.y * column[1] + ray.origin.z * column[2];
    }
};

/// Intervals of s where q >= 0.
struct Intervals {
    int count = 0;
    double low[4], high[4];  // a polynomial of degree 6 has no more

    void add(double a, double b) {
        if (count && a <= high[count - 1]) {
            high[count - 1] = b;
        } else if (count < 4) {
            low[count] = a, high[count++] = b;
        }
    }
};

/// One piece in a ray's frame.
class PieceOnRay {
public:
    /// False if the ray certainly misses all balls, or hits no ball from 0 to `end`, in units of length.
    bool project(const TubePiece& piece, const RayFrame& ray, double end) {
        D4 ball[4];
        for (int i = 0; i < 4; ++i) {
            const double* p = piece.ball[i];
            ball[i] = p[0] * ray.column[0] + p[1] * ray.column[1] + p[2] * ray.column[2] - ray.origin;
            ball[i][3] = p[3];
        }
        const D4 low = smaller(smaller(ball[0], ball[1]), smaller(ball[2], ball[3]));
        const D4 high = larger(larger(ball[0], ball[1]), larger(ball[2], ball[3]));
        const double r = high[3];
        if (low[0] - r > end || high[0] + r < 0) return false;
        if (low[1] > r || low[2] > r || high[1] < -r || high[2] < -r) return false;

        const auto product = [&](int i, int j) {
            const D4 p = ball[i] * ball[j];
            return p[3] - p[1] - p[2];
        };
        double(&q)[7] = whole_.q;
        q[0] = product(0, 0);
        q[1] = product(0, 1);
        q[2] = 0.6 * product(1, 1) + 0.4 * product(0, 2);
        q[3] = 0.9 * product(1, 2) + 0.1 * product(0, 3);
        q[4] = 0.6 * product(2, 2) + 0.4 * product(1, 3);
        q[5] = product(2, 3);
        q[6] = product(3, 3);
        if (!(greatest(q) >= 0)) return false;

        for (int i = 0; i < 4; ++i) whole_.a[i] = ball[i][0];
        power_[0] = ball[0];
        power_[1] = 3 * (ball[1] - ball[0]);
        power_[2] = 3 * (ball[2] - ball[1]) - power_[1];
        power_[3] = ball[3] - ball[0] - 3 * (ball[2] - ball[1]);
        const D4 size = larger(high, -low);
        noise_ = 4e-15 * (size[1] + size[2] + size[3]);
        return true;
    }

    /// The intervals where q >= 0.
    [[nodiscard]] Intervals inside() const {
        Intervals result;
        find_inside(whole_.q, 0, 1, 0, result);
        return result;
    }

    /// The minimum of a - sqrt(q) (sign = 1), or minus the maximum of a + sqrt(q) (sign = -1), over low..high, where q
    /// >= 0; at most `limit`.
    struct Least {
        double value, s;
    };
    [[nodiscard]] Least least_over(double low, double high, double sign, double limit) const {
        Bernstein whole = whole_;
        for (double& a : whole.a) a *= sign;
        Least best{limit, low};
        if (whole.bound() >= limit) return best;
        improve(best, low, sign);
        improve(best, high, sign);
        if (const int shape = shape_of(whole)) {
            if (shape > 0) find_minimum(best, low, high, sign);
        } else {
            Bernstein below, part;
            split(whole.a, high, part.a, below.a);
            split(whole.q, high, part.q, below.q);
            if (low > 0) {
                whole = part;
                split(whole.a, low / high, below.a, part.a);
                split(whole.q, low / high, below.q, part.q);
            }
            search(best, part, low, high, sign, 0);
        }
        return best;
    }

    /// The minimum of a - sqrt(q) over the whole piece, if it is below `best`. False unless bounds prove that f has at
    /// most one critical point, a minimum, and that q >= 0 in one interval, as for concave q. Then neither is computed:
    /// with -q' in place of g where q < 0, g rises from below 0 to above it once.
    [[nodiscard]] bool find_only_minimum(Least& best) const {
        const auto& [a, q] = whole_;
        for (int i = 0; i < 5; ++i) {
            if (q[i] - 2 * q[i + 1] + q[i + 2] > noise_) return false;
        }
        if (shape_of(whole_) <= 0) return false;
        if (whole_.bound() >= best.value) return true;
        const auto end = [&](double s, double at, double at_q) {
            if (at_q >= 0 && at - root(at_q) < best.value) best = {at - root(at_q), s};
        };
        if ((a[1] - a[0]) * root(q[0]) >= q[1] - q[0]) {
            end(0, a[0], q[0]);
        } else if ((a[3] - a[2]) * root(q[6]) <= q[6] - q[5]) {
            end(1, a[3], q[6]);
        } else {
            converge(best, only_minimum_of_parabola(), 0, 1, 1, true);
        }
        return true;
    }

private:
    struct At {
        double f;
        double q;
        double g;  // 2 f' sqrt(q)
        double k;  // and g' where g = 0, or q < 0
    };

    [[nodiscard]] At at(double s, double sign) const {
        const D4 v = ((power_[3] * s + power_[2]) * s + power_[1]) * s + power_[0];
        const D4 v1 = (3 * s * power_[3] + 2 * power_[2]) * s + power_[1];
        const D4 v2 = 6 * s * power_[3] + 2 * power_[2];
        const D4 q0 = v * v, q1 = v * v1, q2 = v1 * v1 + v * v2;
        const double q = q0[3] - q0[1] - q0[2], sqrt_q = root(q);
        const double a1 = sign * v1[0], a2 = sign * v2[0];
        return {sign * v[0] - sqrt_q, q, 2 * (a1 * sqrt_q - (q1[3] - q1[1] - q1[2])),
                2 * (a2 * sqrt_q + (q < 0 ? 0 : a1 * a1) - (q2[3] - q2[1] - q2[2]))};
    }

    void improve(Least& best, double s, double sign) const {
        const double f = at(s, sign).f;
        if (f < best.value) best = {f, s};
    }

    /// Adds the parts of low..high where q, with these coefficients there, is not negative (Descartes' rule of signs).
    void find_inside(const double (&q)[7], double low, double high, int depth, Intervals& result) const {
        if (greatest(q) <= noise_) return;
        if (least(q) >= -noise_) return result.add(low, high);
        int changes = 0;
        bool positive = q[0] >= 0;
        for (int i = 1; i < 7; ++i) {
            const bool next = q[i] >= 0;
            changes += next != positive;
            positive = next;
        }
        if (changes == 1) {
            const double zero = find_zero(q, low, high, positive);
            result.add(positive ? zero : low, positive ? high : zero);
        } else if (depth == 24) {  // a double zero, to rounding
            if (q[0] >= 0 || q[6] >= 0) result.add(low, high);
        } else {
            // At the vertex of the parabola with q's slopes at both ends, if it exists.
            const double rise = q[1] - q[0], fall = q[5] - q[6];
            double at = rise * fall > 0 ? rise / (rise + fall) : 0.5;
            at = larger(smaller(at, 0.9), 0.1);
            double below[7], above[7];
            split(q, at, below, above);
            const double middle = low + at * (high - low);
            find_inside(below, low, middle, depth + 1, result);
            find_inside(above, middle, high, depth + 1, result);
        }
    }

    /// The only zero of q, with these coefficients, in low..high: Newton's method from the sign change of the control
    /// polygon, with bisection outside the bracket. f is never minimal at a zero, but may be next to one, as in thin
    /// tubes, where zeros are close together.
    [[nodiscard]] double find_zero(const double (&coefficients)[7], double low, double high, bool rising) const {
        int i = 0;
        while (i < 5 && (coefficients[i + 1] >= 0) != rising) ++i;
        const double before = coefficients[i], after = coefficients[i + 1];
        double s = low + (high - low) * (i + before / (before - after)) / 6;
        for (int step = 0; step < 60; ++step) {
            const D4 v = ((power_[3] * s + power_[2]) * s + power_[1]) * s + power_[0];
            const D4 v1 = (3 * s * power_[3] + 2 * power_[2]) * s + power_[1];
            const D4 q0 = v * v, q1 = v * v1;
            const double q = q0[3] - q0[1] - q0[2];
            ((q >= 0) == rising ? high : low) = s;
            const double next = s - q / (2 * (q1[3] - q1[1] - q1[2])), change = next - s;
            if (change < 1e-8 && change > -1e-8) return smaller(larger(next, low), high);
            s = next > low && next < high ? next : 0.5 * (low + high);
        }
        return s;
    }

    /// 1 if every critical point of f is a minimum, -1 if every one is a maximum, 0 if undecided.
    [[nodiscard]] int shape_of(const Bernstein& p) const {
        const double a[3] = {3 * (p.a[1] - p.a[0]), 3 * (p.a[2] - p.a[1]), 3 * (p.a[3] - p.a[2])};
        double k[5] = {a[0] * a[0], a[0] * a[1], (2 * a[1] * a[1] + a[0] * a[2]) / 3, a[1] * a[2], a[2] * a[2]};
        for (int i = 0; i < 5; ++i) k[i] = 2 * k[i] - 30 * (p.q[i] - 2 * p.q[i + 1] + p.q[i + 2]);
        const double bend[2] = {4 * (a[1] - a[0]), 4 * (a[2] - a[1])};
        const double sqrt_q = root(greatest(p.q));
        if (least(k) + sqrt_q * smaller(least(bend), 0) >= -30 * noise_) return 1;
        return greatest(k) + sqrt_q * larger(greatest(bend), 0) <= 0 ? -1 : 0;
    }

    /// Finds the minimum of an f without other critical points.
    void find_minimum(Least& best, double low, double high, double sign) const {
        if (at(low, sign).g >= 0 || at(high, sign).g <= 0) return;
        converge(best, 0.5 * (low + high), low, high, sign, false);
    }

    /// The place of the minimum of f if a were linear and q quadratic, as on straight pieces.
    [[nodiscard]] double only_minimum_of_parabola() const {
        const auto& [a, q] = whole_;
        const double middle = (q[0] + q[6] + 6 * (q[1] + q[5]) + 15 * (q[2] + q[4]) + 20 * q[3]) / 64;
        const double slope = a[3] - a[0], rise = 4 * middle - 3 * q[0] - q[6], bend = 4 * middle - 2 * (q[0] + q[6]);
        if (!(bend > 0)) return 0.5;
        const double top = rise / (2 * bend), height = q[0] + 0.5 * rise * top;
        const double s = top - slope * root(height / (bend * (bend + slope * slope)));
        return smaller(larger(s, 0.01), 0.99);
    }

    /// Newton's method, with bisection outside the bracket. Ends if a concave q is below 0 on the whole bracket.
    void converge(Least& best, double s, double low, double high, double sign, bool is_concave) const {
        constexpr double enough = 1e-10, close = 1e-12;  // of f, and of s
        for (int i = 0; i < 60; ++i) {
            const At here = at(s, sign);
            if (is_concave && here.q + here.g * (s - (here.g >= 0 ? low : high)) < 0) return;
            (here.g >= 0 ? high : low) = s;
            const double step = here.g / here.k, next = s - step;
            const bool is_between = next > low && next < high;
            if (here.q >= 0 && here.f < best.value) best = {here.f, is_between ? next : s};
            // The reduction of f by another step.
            if (here.g * step < 4 * enough * root(here.q) || (step < close && step > -close)) break;
            s = is_between ? next : 0.5 * (low + high);
        }
    }

    void search(Least& best, const Bernstein& p, double low, double high, double sign, int depth) const {
        if (p.bound() > best.value - 1e-8) return;
        const double middle = 0.5 * (low + high);
        if (const int shape = shape_of(p)) {
            if (shape > 0) find_minimum(best, low, high, sign);
        } else {
            improve(best, middle, sign);
            // Both f' and f'' are negligible if the shape is still unknown at this depth.
            if (depth == 10) return;
            Bernstein below, above;
            split(p.a, 0.5, below.a, above.a);
            split(p.q, 0.5, below.q, above.q);
            search(best, below, low, middle, sign, depth + 1);
            search(best, above, middle, high, sign, depth + 1);
        }
    }

    Bernstein whole_;
    D4 power_[4];   // coefficients of 1, s, s^2, s^3: coordinates along the ray and across it, and the radius
    double noise_;  // more than rounding in q, for coordinates of about 1
};

/// Intersects a ray with a tube.
class RayThroughTube {
public:
    RayThroughTube(const BvhNode* nodes, const BvhNode* packets, const TubePiece* pieces, const Ray& ray)
        : nodes_(nodes), packets_(packets), pieces_(pieces), boxes_(ray), frame_(ray) {}

    Hit closest_hit() {
        Hit hit;
        bool within = false;
        each_piece(hit, [&](std::uint32_t index, const PieceOnRay& piece) {
            const auto meet = [&](const PieceOnRay::Least& enter) {
                if (!(enter.value < end_)) return;
                end_ = enter.value;
                hit = {static_cast<float>(end_ / frame_.scale), static_cast<float>(enter.s), 0, index};
            };
            PieceOnRay::Least only{end_, 0};
            if (piece.find_only_minimum(only) && only.value > 0) return meet(only);
            const Intervals intervals = piece.inside();
            for (int i = 0; i < intervals.count && !within; ++i) {
                const auto enter = piece.least_over(intervals.low[i], intervals.high[i], 1, end_);
                if (enter.value > 0) {
                    meet(enter);
                } else if (piece.least_over(intervals.low[i], intervals.high[i], -1, 0).value < 0) {
                    within = true;
                    hit.t = 0;  // nothing else is needed
                }
            }
        });
        return within ? leave() : hit;
    }

private:
    template <class Found>
    void each_piece(Hit& hit, Found&& found) {
        traverse(nodes_, boxes_, hit, [&](std::uint32_t packet) {
            const BvhNode& node = packets_[packet];
            alignas(32) float t[8];
            unsigned entered = enter_boxes(node, boxes_, hit.t, t);
            for (; entered; entered &= entered - 1) {
                const int i = __builtin_ctz(entered);
                PieceOnRay piece;
                const std::uint32_t index = node.child[i].bits;
                if (t[i] <= hit.t && piece.project(pieces_[index], frame_, end_)) found(index, piece);
            }
        });
    }

    /// The exit of a ray from inside: joins spans from 0 on until there is a gap.
    Hit leave() {
        // At a joint that the ray grazes, neighbouring spans may be separated by rounding.
        constexpr double gap = 1e-7;
        double reach = 0;
        end_ = gap;
        Hit hit;
        bool grown = true;
        while (grown) {
            grown = false;
            Hit everything;
            each_piece(everything, [&](std::uint32_t index, const PieceOnRay& piece) {
                const Intervals intervals = piece.inside();
                for (int i = 0; i < intervals.count; ++i) {
                    const double low = intervals.low[i], high = intervals.high[i];
                    const auto exit = piece.least_over(low, high, -1, -reach);
                    if (!(exit.value < -reach) || !(piece.least_over(low, high, 1, infinity).value <= end_)) continue;
                    grown = true;
                    reach = -exit.value;
                    end_ = reach + gap;
                    hit = {static_cast<float>(reach / frame_.scale), static_cast<float>(exit.s), 0, index};
                }
            });
        }
        return hit;
    }

    static constexpr double infinity = std::numeric_limits<double>::infinity();

    const BvhNode* nodes_;
    const BvhNode* packets_;
    const TubePiece* pieces_;
    RayThroughBoxes boxes_;
    RayFrame frame_;
    double end_ = infinity;  // later spans are ignored; in units of length
};

void closest_hits(const BvhNode* nodes, const BvhNode* packets, const TubePiece* pieces, const Ray* rays,
                  std::size_t count, Hit* hits) {
    for (std::size_t i = 0; i < count; ++i) hits[i] = RayThroughTube(nodes, packets, pieces, rays[i]).closest_hit();
}

}  // namespace

const TubeKernels tube_kernels = {closest_hits};

}  // namespace bob::BOB_ISA
