#include "files/draco/connectivity.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>

#include "base/interruption.h"
#include "files/draco/entropy.h"
#include "files/text.h"

namespace bob::files::draco {
namespace {

constexpr std::uint64_t max_steps = 400'000'000;  // around vertices that are merged
constexpr std::uint64_t corner_bytes = 24, cut_bytes = 13;

[[noreturn]] void refuse_triangles() { refuse({"expected triangles that fit together, got others"}); }

/// Kinds of triangles by the edges that they share with earlier ones.
enum Symbol : std::uint8_t { center, split, left_edge, right_edge, end };

/// An edge that a later `split` joins.
struct Event {
    std::uint32_t source, split;
    bool is_right;
};

std::vector<Event> events_of(Stream& stream, std::size_t triangles) {
    const std::uint32_t count = stream.varint();
    if (count > triangles || count > stream.size()) refuse_triangles();
    std::vector<Event> events;
    std::uint32_t source = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        source += stream.varint();
        const std::uint32_t back = stream.varint();
        if (back > source) refuse_triangles();
        events.push_back({source, source - back, false});
    }
    Bits bits(stream.rest());
    for (Event& event : events) event.is_right = bits.read(1);
    static_cast<void>(stream.take(bits.used()));
    return events;
}

/// The sequence of symbols: plain bits, or coded by the number of triangles around the next vertex.
class Symbols {
public:
    Symbols(Stream& stream, bool is_by_valence) {
        if (!is_by_valence) plain_.emplace(stream.take(stream.varint()));
    }

    void read_contexts(Stream& stream, std::size_t triangles, std::size_t vertices, Budget& budget) {
        if (plain_) return;
        budget.take(4 * std::uint64_t{vertices});
        valences_.resize(vertices);
        for (auto& context : contexts_) {
            const std::uint32_t count = stream.varint();
            if (count > triangles) refuse_triangles();
            context = symbols(stream, count, 1, budget);
        }
    }

    Symbol next() {
        if (plain_) {
            constexpr Symbol of_bits[] = {split, left_edge, right_edge, end};
            last_ = plain_->read(1) ? of_bits[plain_->read(2)] : center;
        } else if (!context_) {
            last_ = end;
        } else {
            if (context_->empty() || context_->back() > end) refuse_triangles();
            last_ = static_cast<Symbol>(context_->back());
            context_->pop_back();
        }
        return last_;
    }

    /// Counts the triangle of the last symbol at its corner, its next and its previous one.
    void count(const Corners& corners, std::int32_t c) {
        if (plain_) return;
        constexpr std::array<int, 3> counts[] = {{0, 1, 1}, {0, 1, 1}, {1, 2, 1}, {1, 1, 2}, {2, 2, 2}};
        const std::int32_t three[] = {c, Corners::next(c), Corners::previous(c)};
        for (std::size_t k = 0; k < 3; ++k) valence(corners.vertex_of(three[k])) += counts[last_][k];
        context_ = &contexts_[static_cast<std::size_t>(std::clamp(valence(corners.vertex_of(three[1])), 2, 7) - 2)];
    }
    void merge(std::int32_t into, std::int32_t from) {
        if (!plain_) valence(into) += valence(from);
    }

private:
    int& valence(std::int32_t vertex) { return valences_[static_cast<std::size_t>(vertex)]; }

    std::optional<Bits> plain_;
    std::array<std::vector<std::uint32_t>, 6> contexts_;
    std::vector<std::uint32_t>* context_ = nullptr;
    std::vector<int> valences_;
    Symbol last_ = end;
};

/// Puts triangles together, from the last one that was encoded to the first.
class Builder {
public:
    Builder(std::size_t triangles, std::size_t max_vertices) : max_vertices_(max_vertices), triangles_(triangles) {
        corners_.opposite.assign(3 * triangles, -1);
        corners_.vertex.assign(3 * triangles, -1);
    }

    void build(std::size_t count, Symbols& symbols, std::vector<Event> events, AnsBits& starts);
    /// Leaves out vertices that were merged; returns how many are left.
    std::size_t remove_merged();

    [[nodiscard]] Corners corners() && { return std::move(corners_); }

private:
    std::int32_t new_vertex() {
        if (corners_.leftmost.size() >= max_vertices_) refuse_triangles();
        corners_.leftmost.push_back(-1);
        return static_cast<std::int32_t>(corners_.leftmost.size() - 1);
    }
    std::int32_t top() const {
        if (active_.empty()) refuse_triangles();
        return active_.back();
    }
    std::int32_t of(std::int32_t c) const {
        if (c < 0 || corners_.vertex_of(c) < 0) refuse_triangles();
        return corners_.vertex_of(c);
    }
    void set(std::int32_t c, std::int32_t v) { corners_.vertex[static_cast<std::size_t>(c)] = v; }
    std::int32_t& leftmost(std::int32_t v) { return corners_.leftmost[static_cast<std::size_t>(v)]; }
    void join(std::int32_t a, std::int32_t b) {
        if (a < 0 || b < 0 || a == b || corners_.across(a) >= 0 || corners_.across(b) >= 0) refuse_triangles();
        corners_.opposite[static_cast<std::size_t>(a)] = b;
        corners_.opposite[static_cast<std::size_t>(b)] = a;
    }
    /// The corner whose opposite edge comes next to the left around the vertex after c.
    std::int32_t beyond(std::int32_t c) { return Corners::next(leftmost(of(Corners::next(c)))); }

    void add_center(std::int32_t c);
    void add_edge(std::int32_t c, bool is_right);
    void add_split(std::int32_t c, std::size_t number, Symbols& symbols);
    void add_end(std::int32_t c);
    void add_start(std::int32_t c, std::int32_t a);

    static constexpr auto next = Corners::next, previous = Corners::previous;
    Corners corners_;
    std::size_t max_vertices_, triangles_;
    std::vector<std::int32_t> active_;                            // corners whose opposite edges are open
    std::unordered_map<std::size_t, std::int32_t> split_corners_;  // by the numbers of `split` symbols
    std::vector<std::int32_t> merged_;
    std::uint64_t steps_ = 0;
};

void Builder::add_center(std::int32_t c) {
    const std::int32_t a = top(), x = of(next(a)), b = beyond(a);
    join(a, c + 1);
    join(b, c + 2);
    const std::int32_t before = of(previous(a)), after = of(next(b));
    if (x == before || x == after) refuse_triangles();
    set(c, x), set(c + 1, after), set(c + 2, before);
    leftmost(before) = c + 2;
    active_.back() = c;
}

void Builder::add_edge(std::int32_t c, bool is_right) {
    const std::int32_t a = top(), tip = is_right ? c + 2 : c + 1, on_left = is_right ? c + 1 : c, on_right = is_right ? c : c + 2;
    join(tip, a);
    const std::int32_t vertex = new_vertex(), right = of(previous(a));
    set(tip, vertex), set(on_right, right), set(on_left, of(next(a)));
    leftmost(vertex) = tip;
    leftmost(right) = on_right;
    active_.back() = c;
}

void Builder::add_split(std::int32_t c, std::size_t number, Symbols& symbols) {
    const std::int32_t b = top();
    active_.pop_back();
    if (const auto found = split_corners_.find(number); found != split_corners_.end()) active_.push_back(found->second);
    const std::int32_t a = top();
    if (a == b) refuse_triangles();
    join(a, c + 2);
    join(b, c + 1);
    const std::int32_t p = of(previous(a)), before = of(previous(b)), n = of(next(b));
    set(c, p), set(c + 1, of(next(a))), set(c + 2, before);
    leftmost(before) = c + 2;
    symbols.merge(p, n);
    leftmost(p) = leftmost(n);
    const std::int32_t first = next(b);
    for (std::int32_t at = first; at >= 0;) {
        if (++steps_ > max_steps) refuse_triangles();
        set(at, p);
        at = corners_.left(at);
        if (at == first) refuse_triangles();
    }
    leftmost(n) = -1;
    merged_.push_back(n);
    active_.back() = c;
}

void Builder::add_end(std::int32_t c) {
    for (std::int32_t k = c; k < c + 3; ++k) {
        const std::int32_t vertex = new_vertex();
        set(k, vertex);
        leftmost(vertex) = k;
    }
    active_.push_back(c);
}

/// The triangle that encoding started from, between three open edges.
void Builder::add_start(std::int32_t c, std::int32_t a) {
    const std::int32_t n = of(next(a)), b = beyond(a), x = of(next(b)), far = beyond(b), p = of(next(far));
    join(c, a);
    join(c + 1, b);
    join(c + 2, far);
    set(c, x), set(c + 1, p), set(c + 2, n);
}

void Builder::build(std::size_t count, Symbols& symbols, std::vector<Event> events, AnsBits& starts) {
    std::size_t built = 0;
    for (; built < count; ++built) {
        if (built % 65536 == 0) Interruption::check();
        const auto c = static_cast<std::int32_t>(3 * built);
        const Symbol symbol = symbols.next();
        if (symbol == center) {
            add_center(c);
        } else if (symbol == split) {
            add_split(c, built, symbols);
        } else if (symbol == end) {
            add_end(c);
        } else {
            add_edge(c, symbol == right_edge);
        }
        symbols.count(corners_, active_.back());
        if (symbol == center || symbol == split) continue;
        const std::size_t encoded = count - built - 1;
        for (; !events.empty() && events.back().source >= encoded; events.pop_back()) {
            const Event& event = events.back();
            if (event.source > encoded || event.split >= count) refuse_triangles();
            split_corners_[count - event.split - 1] = event.is_right ? next(active_.back()) : previous(active_.back());
        }
    }
    for (; !active_.empty();) {
        const std::int32_t a = active_.back();
        active_.pop_back();
        if (!starts.read()) continue;
        if (built >= triangles_) refuse_triangles();
        add_start(static_cast<std::int32_t>(3 * built++), a);
    }
    if (built != triangles_) refuse_triangles();
}

std::size_t Builder::remove_merged() {
    std::size_t count = corners_.leftmost.size();
    for (const std::int32_t hole : merged_) {
        while (count > 0 && corners_.leftmost[count - 1] < 0) --count;
        const auto last = static_cast<std::int32_t>(count) - 1;
        if (last < hole) continue;
        corners_.around(leftmost(last), [&](std::int32_t c) {
            if (of(c) != last) refuse_triangles();
            set(c, hole);
            return true;
        });
        leftmost(hole) = leftmost(last);
        leftmost(last) = -1;
        --count;
    }
    return count;
}

/// Cuts triangles along the edges opposite to some corners, and renumbers the vertices.
Corners cut_along(const Corners& whole, const std::vector<std::int32_t>& seam) {
    Corners result{.opposite = whole.opposite, .vertex = std::vector<std::int32_t>(whole.vertex.size(), -1), .leftmost = {}};
    for (const std::int32_t c : seam) {
        if (const std::int32_t other = result.across(c); other >= 0) result.opposite[static_cast<std::size_t>(other)] = -1;
        result.opposite[static_cast<std::size_t>(c)] = -1;
    }
    for (const std::int32_t start : whole.leftmost) {
        if (start < 0) continue;
        std::int32_t first = start;
        for (std::int32_t at = result.left(start); at >= 0; at = result.left(at)) {
            if (at == start) {
                first = start;
                break;
            }
            first = at;
        }
        const auto add = [&](std::int32_t c) { result.leftmost.push_back(c); };
        add(first);
        result.vertex[static_cast<std::size_t>(first)] = static_cast<std::int32_t>(result.leftmost.size()) - 1;
        for (std::int32_t at = whole.right(first); at >= 0 && at != first; at = whole.right(at)) {
            if (result.across(Corners::next(at)) < 0) add(at);
            result.vertex[static_cast<std::size_t>(at)] = static_cast<std::int32_t>(result.leftmost.size()) - 1;
        }
    }
    if (std::ranges::any_of(result.vertex, [](std::int32_t v) { return v < 0; })) refuse_triangles();
    return result;
}

/// Numbers points: corners of a vertex that are one vertex of every attribute are one point.
void assign_points(Connectivity& mesh) {
    const Corners& corners = mesh.corners;
    mesh.points.assign(corners.vertex.size(), -1);
    const auto differ = [&](std::int32_t a, std::int32_t b) {
        return std::ranges::any_of(mesh.cut, [&](const Corners& cut) { return cut.vertex_of(a) != cut.vertex_of(b); });
    };
    for (const std::int32_t start : corners.leftmost) {
        if (start < 0) continue;
        std::int32_t first = start;
        if (corners.left(start) >= 0) {
            // Draco starts at a seam of the first attribute that has one here.
            for (const Corners& cut : mesh.cut) {
                std::int32_t at = corners.right(start);
                while (at >= 0 && at != start && cut.vertex_of(at) == cut.vertex_of(start)) at = corners.right(at);
                if (at < 0) refuse_triangles();
                if (at == start) continue;
                first = at;
                break;
            }
        }
        std::int32_t before = -1, at = first;
        do {
            if (before < 0 || differ(before, at)) ++mesh.point_count;
            mesh.points[static_cast<std::size_t>(at)] = static_cast<std::int32_t>(mesh.point_count) - 1;
            before = at;
            at = corners.right(at);
        } while (at >= 0 && at != first);
    }
    if (std::ranges::any_of(mesh.points, [](std::int32_t point) { return point < 0; })) refuse_triangles();
}

}  // namespace

Connectivity edgebreaker(Stream& stream, std::size_t max_triangles, Budget& budget) {
    const std::uint8_t traversal = stream.number();
    if (traversal != 0 && traversal != 2) refuse({"expected edgebreaker by symbols or valences, got another kind"});
    const std::uint32_t vertices = stream.varint(), triangles = stream.varint();
    const std::uint8_t attributes = stream.number();
    const std::uint32_t count = stream.varint(), splits = stream.varint();
    if (triangles > max_triangles) refuse({"expected at most ", grouped(max_triangles), " triangles, as its accessor says, got ", grouped(triangles)});
    if (triangles > std::numeric_limits<std::int32_t>::max() / 3 || vertices > std::uint64_t{3} * triangles || count > triangles || splits > count) {
        refuse_triangles();
    }
    budget.take(3 * std::uint64_t{triangles} * (corner_bytes + attributes * cut_bytes));

    std::vector<Event> events = events_of(stream, triangles);
    Symbols symbols(stream, traversal == 2);
    AnsBits starts(stream);
    std::vector<AnsBits> seams;
    for (int i = 0; i < attributes; ++i) seams.emplace_back(stream);
    symbols.read_contexts(stream, triangles, std::size_t{vertices} + splits, budget);
    Builder builder(triangles, std::size_t{vertices} + splits);
    builder.build(count, symbols, std::move(events), starts);

    Connectivity result;
    if (!attributes) {
        result.point_count = builder.remove_merged();
        result.corners = std::move(builder).corners();
        result.points = result.corners.vertex;
        if (std::ranges::any_of(result.points, [&](std::int32_t v) { return v < 0 || static_cast<std::size_t>(v) >= result.point_count; })) refuse_triangles();
        return result;
    }
    result.corners = std::move(builder).corners();
    std::vector<std::vector<std::int32_t>> seam_corners(attributes);
    for (std::int32_t first = 0; first < static_cast<std::int32_t>(result.corners.vertex.size()); first += 3) {
        for (const std::int32_t c : {first, first + 1, first + 2}) {
            const std::int32_t other = result.corners.across(c);
            if (other >= 0 && other < first) continue;  // the edge was met before
            for (std::size_t i = 0; i < seams.size(); ++i) {
                if (other >= 0 && seams[i].read()) seam_corners[i].push_back(c);
            }
        }
    }
    for (const auto& seam : seam_corners) result.cut.push_back(cut_along(result.corners, seam));
    assign_points(result);
    return result;
}

}  // namespace bob::files::draco
