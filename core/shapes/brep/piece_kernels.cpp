#include <algorithm>
#include <vector>

#include "base/thread_memory.h"
#include "shapes/brep/flight.h"

namespace bob::BOB_ISA {
namespace {

// Enough to fill the lanes before all rays wait; 2 and 8 times the lanes are as fast.
constexpr std::uint32_t in_flight = 4 * lanes;

/// Rays that wait for searches in patches of the same degrees.
struct Waiting {
    Newton<lanes> newton;
    std::uint32_t flight[lanes];
};

/// Memory kept between calls.
struct Memory {
    Flight flights[in_flight];
    std::vector<Waiting> waiting;  // for each pair of degrees: for Newton's method alone, and with a test before it
    PatchLanes<lanes> patches;
    Workspace workspace;
};

/// All rays of a call. Rays in flight that wait for equal degrees share the lanes of one search.
class Tracing {
public:
    Tracing(const Pieces& pieces, std::span<const Ray> rays, Hit* hits, Memory& memory)
        : pieces_(pieces), rays_(rays), hits_(hits), memory_(memory) {
        if (memory.waiting.size() < 2 * pieces.pairs_of_degrees) memory.waiting.resize(2 * pieces.pairs_of_degrees);
        for (Waiting& some : memory.waiting) some.newton.clear();  // left by an interrupted call
    }

    void run() {
        for (std::uint32_t i = 0; i < in_flight && next_ < rays_.size(); ++i) {
            if (begin(i)) go_on(i);
        }
        while (true) {
            while (count_ready_) go_on(ready_[--count_ready_]);
            Waiting* fullest = &memory_.waiting[0];
            for (Waiting& some : memory_.waiting) {
                if (some.newton.count() > fullest->newton.count()) fullest = &some;
            }
            if (!fullest->newton.count()) break;
            solve(*fullest);
        }
    }

private:
    /// Starts the next ray, if there is one.
    bool begin(std::uint32_t flight) {
        while (next_ < rays_.size()) {
            if (next_ == end_of_beam_) {
                begin_of_beam_ = next_;
                end_of_beam_ = std::min(next_ + Beam::most_rays, rays_.size());
                are_alike_ = beam_.begin(pieces_.nodes.data(), rays_.subspan(next_, end_of_beam_ - next_));
            }
            Flight& some = memory_.flights[flight];
            while (next_ < end_of_beam_) {
                const std::size_t i = next_++;
                if (!are_alike_) {
                    some.begin(pieces_, rays_[i], static_cast<std::uint32_t>(i));
                    return true;
                }
                if (!beam_.is_empty() && some.begin(pieces_, rays_[i], static_cast<std::uint32_t>(i), beam_, i - begin_of_beam_)) return true;
                hits_[i] = {};
            }
        }
        return false;
    }

    /// Advances it until it waits, or no rays are left.
    void go_on(std::uint32_t i) {
        Flight& flight = memory_.flights[i];
        while (!flight.go_on(pieces_)) {
            hits_[flight.number()] = flight.result();
            if (!begin(i)) return;
        }
        Waiting& some = memory_.waiting[2 * flight.patch(pieces_).degrees + flight.looks()];
        some.flight[some.newton.count()] = i;
        flight.ask(pieces_, some.newton);
        if (some.newton.is_full()) solve(some);
    }

    void solve(Waiting& some) {
        some.newton.solve(pieces_, memory_.patches);
        for (int lane = 0; lane < some.newton.count(); ++lane) {
            memory_.flights[some.flight[lane]].take(pieces_, memory_.workspace, some.newton, lane);
            ready_[count_ready_++] = some.flight[lane];
        }
        some.newton.clear();
    }

    const Pieces& pieces_;
    std::span<const Ray> rays_;
    Hit* hits_;
    Memory& memory_;
    std::size_t next_ = 0, begin_of_beam_ = 0, end_of_beam_ = 0;  // among the rays
    Beam beam_;
    bool are_alike_ = false;  // the rays of the beam
    std::uint32_t ready_[in_flight], count_ready_ = 0;
};

void closest_hits(const Pieces& pieces, std::span<const Ray> rays, Hit* hits) {
    Tracing(pieces, rays, hits, thread_memory<Memory>()).run();
}

/// dS/du x dS/dv, of any length, and whether the squared sine of their angle exceeds `parallel`.
struct Normals {
    F x[3];
    M known;
};

inline Normals normals_at(const PatchLanes<lanes>& patches, F u, F v, float parallel) {
    Jets<lanes> jets;
    patches.evaluate(u, v, jets);
    F s_u[3], s_v[3];
    for (int axis = 0; axis < 3; ++axis) {
        const F x = jets.x[axis] / jets.x[3];
        s_u[axis] = fma(-jets.u[3], x, jets.u[axis]), s_v[axis] = fma(-jets.v[3], x, jets.v[axis]);
    }
    const F n[3] = {s_u[1] * s_v[2] - s_u[2] * s_v[1], s_u[2] * s_v[0] - s_u[0] * s_v[2], s_u[0] * s_v[1] - s_u[1] * s_v[0]};
    const auto square = [](const F(&a)[3]) { return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]; };
    return {{n[0], n[1], n[2]}, square(n) > parallel * square(s_u) * square(s_v)};
}

void normals(const Pieces& pieces, std::span<const Hit> hits, Vec3* normals) {
    const auto degrees = [&](std::size_t i) { return pieces.patches[hits[i].primitive].degrees; };
    PatchLanes<lanes> patches;
    for (std::size_t begin = 0, end; begin < hits.size(); begin = end) {
        F u{}, v{};
        std::uint32_t patch[lanes];
        for (end = begin; end < hits.size() && end - begin < lanes && degrees(end) == degrees(begin); ++end) {
            const auto lane = end - begin;
            patch[lane] = hits[end].primitive, u[lane] = hits[end].u, v[lane] = hits[end].v;
        }
        const int count = static_cast<int>(end - begin);
        patches.load(pieces, patch, count);
        constexpr float but_for_rounding = 1e-9f;
        Normals found = normals_at(patches, u, v, but_for_rounding);
        M wanted;
        for (int lane = 0; lane < lanes; ++lane) wanted[lane] = lane < count ? -1 : 0;
        const auto find = [&](float nearer, float parallel) {
            const F half = constant(0.5f);
            const F at_u = fma(half - u, constant(nearer), u), at_v = fma(half - v, constant(nearer), v);
            const Normals other = normals_at(patches, at_u, at_v, parallel);
            for (int axis = 0; axis < 3; ++axis) found.x[axis] = found.known ? found.x[axis] : other.x[axis];
            found.known |= other.known;
        };
        // At a pole, takes the normal of a nearby point, towards the middle of the patch.
        for (float nearer = 1e-3f; bits(wanted & ~found.known) && nearer < 0.5f; nearer *= 4) find(nearer, but_for_rounding);
        if (bits(wanted & ~found.known)) find(0, 0);  // for a needle
        for (std::size_t i = begin; i < end; ++i) {
            const auto lane = i - begin;
            normals[i] = normalized({found.x[0][lane], found.x[1][lane], found.x[2][lane]});
        }
    }
}

}  // namespace

const PieceKernels piece_kernels = {closest_hits, normals};

}  // namespace bob::BOB_ISA
