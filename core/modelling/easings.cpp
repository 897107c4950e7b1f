/// Easing functions: from 0 at t = 0 to 1 at t = 1, with the values of fogleman/sdf's (easings.net shows them).
#include <numbers>

#include "modelling/words.h"

namespace bob {
namespace {

using std::numbers::pi;

/// One formula before the middle, one after; each is evaluated in its half only.
template <class First, class Second>
Value halves(Value t, First first, Second second) {
    const Value after = second(max(t, 0.5)), before = first(min(t, 0.5));
    return select(t - 0.5, before, after);
}

/// 2^v.
Value exp2(Value v) { return exp(v * std::numbers::ln2); }

/// `special` at t = place, elsewhere `usual`.
Value except_at(Value t, double place, double special, Value usual) {
    const Value there = t.graph->constant(special);
    return select(-abs(t - place), usual, there);
}

Value linear(Value t) { return t; }

template <int n>
Value in_power(Value t) {
    return power(t, n);
}

template <int n>
Value out_power(Value t) {
    return n % 2 ? power(t - 1, n) + 1 : 1 - power(t - 1, n);
}

template <int n>
Value in_out_power(Value t) {
    return halves(
        t, [](Value s) { return 0.5 * power(2 * s, n); }, [](Value s) { return 0.5 * out_power<n>(2 * s - 1) + 0.5; });
}

Value in_sine(Value t) { return 1 - cos(t * (pi / 2)); }
Value out_sine(Value t) { return sin(t * (pi / 2)); }
Value in_out_sine(Value t) { return 0.5 - 0.5 * cos(t * pi); }

Value in_expo(Value t) { return except_at(t, 0, 0, exp2(10 * (t - 1))); }
Value out_expo(Value t) { return except_at(t, 1, 1, 1 - exp2(-10 * t)); }
Value in_out_expo(Value t) {
    const Value usual = halves(
        t, [](Value s) { return 0.5 * exp2(20 * s - 10); }, [](Value s) { return 1 - 0.5 * exp2(10 - 20 * s); });
    return except_at(t, 0, 0, except_at(t, 1, 1, usual));
}

/// The height of the unit circle over u; 0 outside it.
Value arc(Value u) { return sqrt(max(1 - square(u), 0)); }
Value in_circ(Value t) { return 1 - arc(t); }
Value out_circ(Value t) { return arc(t - 1); }
Value in_out_circ(Value t) {
    return halves(
        t, [](Value s) { return 0.5 - 0.5 * arc(2 * s); }, [](Value s) { return 0.5 + 0.5 * arc(2 * s - 2); });
}

/// A sine wave of period k.
Value swing(Value t, double k) { return sin((t - k / 4) * (2 * pi / k)); }
/// A sine wave whose amplitude halves with every tenth of t.
Value dying_swing(Value t, double k) {
    const Value swinging = swing(t, k);
    return exp2(-10 * t) * swinging;
}
/// A sine wave whose amplitude doubles with every tenth until t = 1.
Value growing_swing(Value t, double k) {
    const Value swinging = swing(t - 1, k);
    return exp2(10 * (t - 1)) * swinging;
}
Value in_elastic(Value t, double k) { return -growing_swing(t, k); }
Value out_elastic(Value t, double k) { return dying_swing(t, k) + 1; }
Value in_out_elastic(Value t, double k) {
    return halves(
        t, [k](Value s) { return -0.5 * growing_swing(2 * s, k); },
        [k](Value s) { return 0.5 * dying_swing(2 * s - 1, k) + 1; });
}

constexpr double overshoot = 1.70158;  // an overshoot of a tenth
Value back(Value t, double k) {
    const Value beyond = (k + 1) * t - k;
    return square(t) * beyond;
}
Value in_back(Value t) { return back(t, overshoot); }
Value out_back(Value t) { return 1 - back(1 - t, overshoot); }
Value in_out_back(Value t) {
    constexpr double k = overshoot * 1.525;
    return halves(
        t, [](Value s) { return 0.5 * back(2 * s, k); }, [](Value s) { return 1 - 0.5 * back(2 - 2 * s, k); });
}

/// a t^2 + b t + c, with a single occurrence of t.
Value parabola(Value t, double a, double b, double c) {
    const double vertex = -b / (2 * a);
    return a * square(t - vertex) + (c - a * vertex * vertex);
}
Value out_bounce(Value t) {
    constexpr double first = 4.0 / 11, second = 8.0 / 11, third = 9.0 / 10;
    const Value a = parabola(min(t, first), 121.0 / 16, 0, 0);
    const Value b = parabola(clamp(t, first, second), 363.0 / 40, -99.0 / 10, 17.0 / 5);
    const Value c = parabola(clamp(t, second, third), 4356.0 / 361, -35442.0 / 1805, 16061.0 / 1805);
    const Value d = parabola(max(t, third), 54.0 / 5, -513.0 / 25, 268.0 / 25);
    const Value last = select(t - third, c, d), late = select(t - second, b, last);
    return select(t - first, a, late);
}
Value in_bounce(Value t) { return 1 - out_bounce(1 - t); }
Value in_out_bounce(Value t) {
    return halves(
        t, [](Value s) { return 0.5 * in_bounce(2 * s); }, [](Value s) { return 0.5 * out_bounce(2 * s - 1) + 0.5; });
}

Value step(Value condition, double low, double high) {
    const Value after = condition.graph->constant(high), before = condition.graph->constant(low);
    return select(condition, before, after);
}
Value in_square(Value t) { return step(t - 1, 0, 1); }
Value out_square(Value t) { return step(-t, 1, 0); }
Value in_out_square(Value t) { return step(t - 0.5, 0, 1); }

// ---- The table -------------------------------------------------------------------------------------------

Object result(const Arguments& a, const Expression& easing) {
    if (a.has("t")) return object(easing(a.number("t"), 0, 0));
    return {Easing{std::make_shared<const Expression>(easing)}};
}

template <Value (*f)(Value)>
Object ease(const Arguments& a) {
    Graph graph;
    return result(a, graph.expression(f(graph.x())));
}

template <Value (*f)(Value, double)>
Object ease_with_k(const Arguments& a) {
    const double k = a.nonzero("k");
    Graph graph;
    return result(a, graph.expression(f(graph.x(), k)));
}

}  // namespace

void add_easings(std::vector<Word>& words) {
    const auto easing = [&](std::string_view name, Object (*call)(const Arguments&), std::string_view meaning) {
        words.push_back({name, Word::Kind::easing, 0, 0, {optional("t", Type::number)}, meaning, call});
    };
    const auto elastic = [&](std::string_view name, Object (*call)(const Arguments&), std::string_view meaning) {
        easing(name, call, meaning);
        words.back().parameters.push_back(with_default("k", Type::number, 0.5));
    };
    easing("linear", ease<linear>, "Constant speed.");
    easing("in_quad", ease<in_power<2>>, "Speeds up: a parabola.");
    easing("out_quad", ease<out_power<2>>, "Slows down: a parabola.");
    easing("in_out_quad", ease<in_out_power<2>>, "Speeds up, then slows down: parabolas.");
    easing("in_cubic", ease<in_power<3>>, "Speeds up as the third power.");
    easing("out_cubic", ease<out_power<3>>, "Slows down as the third power.");
    easing("in_out_cubic", ease<in_out_power<3>>, "Speeds up, then slows down, as the third power.");
    easing("in_quart", ease<in_power<4>>, "Speeds up as the fourth power.");
    easing("out_quart", ease<out_power<4>>, "Slows down as the fourth power.");
    easing("in_out_quart", ease<in_out_power<4>>, "Speeds up, then slows down, as the fourth power.");
    easing("in_quint", ease<in_power<5>>, "Speeds up as the fifth power.");
    easing("out_quint", ease<out_power<5>>, "Slows down as the fifth power.");
    easing("in_out_quint", ease<in_out_power<5>>, "Speeds up, then slows down, as the fifth power.");
    easing("in_sine", ease<in_sine>, "Speeds up like a swing from its turning point.");
    easing("out_sine", ease<out_sine>, "Slows down like a swing to its turning point.");
    easing("in_out_sine", ease<in_out_sine>, "Half a swing, from one turning point to the other.");
    easing("in_expo", ease<in_expo>, "Doubles every tenth of the way.");
    easing("out_expo", ease<out_expo>, "Halves the remainder every tenth of the way.");
    easing("in_out_expo", ease<in_out_expo>, "Doubles every twentieth of the way, then halves the remainder.");
    easing("in_circ", ease<in_circ>, "Speeds up: a quarter of a circle, level at the start.");
    easing("out_circ", ease<out_circ>, "Slows down: a quarter of a circle, level at the end.");
    easing("in_out_circ", ease<in_out_circ>, "Two quarters of circles, level at both ends.");
    elastic("in_elastic", ease_with_k<in_elastic>, "Oscillates with period k and growing amplitude, then moves.");
    elastic("out_elastic", ease_with_k<out_elastic>, "Overshoots, then oscillates with period k and shrinking amplitude.");
    elastic("in_out_elastic", ease_with_k<in_out_elastic>, "Oscillates at both ends, with half the period k.");
    easing("in_back", ease<in_back>, "Draws back by a tenth first.");
    easing("out_back", ease<out_back>, "Overshoots by a tenth, then returns.");
    easing("in_out_back", ease<in_out_back>, "Draws back first, and overshoots at the end.");
    easing("in_bounce", ease<in_bounce>, "Bounces higher and higher.");
    easing("out_bounce", ease<out_bounce>, "Falls and bounces lower and lower.");
    easing("in_out_bounce", ease<in_out_bounce>, "Bounces at both ends.");
    easing("in_square", ease<in_square>, "Jumps at the end.");
    easing("out_square", ease<out_square>, "Jumps at the start.");
    easing("in_out_square", ease<in_out_square>, "Jumps in the middle.");
}

}  // namespace bob
