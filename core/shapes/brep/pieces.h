/// Bezier patches, cut into pieces that rays meet.
///
/// A piece is so flat that Newton's method finds where a ray meets it, and that a ray meets it once at most, but for rays
/// nearly tangent to it. (Abert, Geimer and Mueller, "Direct and Fast Ray Tracing of NURBS Surfaces", 2006, start
/// Newton's method likewise, without the proof that there is no second hit.)
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/bvh.h"
#include "base/isa.h"
#include "nurbs/nurbs.h"
#include "nurbs/trim.h"
#include "shapes/shape.h"

namespace bob {

/// A Bezier patch in float32, relative to its own centre, so that small patches lose nothing to rounding.
struct Patch {
    float center[3];
    std::uint32_t control_points;  // where they begin: (w x, w y, w z, w) each, v fastest
    std::uint16_t degree_u, degree_v;
    std::uint32_t degrees;  // which pair of degrees that is, among all that the pieces' patches have
    std::uint32_t face;
    const TrimRegion* region;  // of the face, in its own parameters
    Domain domain;             // of the face's parameters that are the patch's 0..1
    float margin_u, margin_v;  // how far beyond its region the face is seen

    /// The face's parameters at parameters 0..1 of the patch.
    [[nodiscard]] double face_u(double u) const { return domain.low_u + u * (domain.high_u - domain.low_u); }
    [[nodiscard]] double face_v(double v) const { return domain.low_v + v * (domain.high_v - domain.low_v); }

    /// How much of a rectangle of the face's parameters is seen. Adds how many nodes of the region that took.
    [[nodiscard]] TrimRegion::Coverage coverage(const Domain& rectangle, std::size_t* visited = nullptr) const;

    /// A rectangle of the face's parameters around what of another is seen; low > high where nothing is.
    [[nodiscard]] Domain extent(const Domain& rectangle, std::size_t* visited = nullptr) const;

    /// Whether the point at parameters 0..1 of the patch is seen: `some` where that is beyond the region.
    [[nodiscard]] TrimRegion::Coverage coverage(double u, double v) const;
};

/// What is seen of a piece that a trim crosses: a grid of squares in its parameters.
struct TrimCells {
    static constexpr int side = 8;

    std::uint64_t seen = 0, crossed = 0;  // bit side * v + u: all of the square is seen; only a look at the curves can tell

    /// Whether a point of the piece is seen, at parameters 0..1 of it; `some` where the curves decide.
    [[nodiscard]] TrimRegion::Coverage at(float u, float v) const {
        const auto index = [](float x) { return static_cast<std::uint64_t>(x * side); };
        if (!(u >= 0 && u < 1 && v >= 0 && v < 1)) return TrimRegion::Coverage::some;
        const std::uint64_t bit = std::uint64_t{1} << (side * index(v) + index(u));
        return crossed & bit ? TrimRegion::Coverage::some : seen & bit ? TrimRegion::Coverage::all : TrimRegion::Coverage::none;
    }
};

/// 704 bytes. A piece lies in a box whose x and y axes follow its u and v: to_box * (p, 1) has |x| and |y| up to `half`,
/// |z| up to 1, and is about at the parameters low + (0.5 + 0.5 (x, y)) size of the patch. An absent piece's box is entered
/// by no ray.
struct alignas(32) PiecePacket {
    static constexpr std::uint32_t no_trim = 0xffffffff;

    float to_box[3][4][8];
    float half[2][8];
    float lean[2][8];  // only a ray whose direction has |z| <= lean[0] |x| + lean[1] |y| may meet the piece twice
    float low[2][8], size[2][8];
    std::uint32_t patch[8], trim[8];  // and, where the face's region crosses the piece, its cells
};

struct Pieces {
    std::vector<Patch> patches;
    std::vector<std::array<float, 4>> control_points;
    std::uint32_t pairs_of_degrees = 0;
    std::vector<BvhNode> nodes;
    std::vector<PiecePacket> packets;
    std::vector<TrimCells> trims;
    std::size_t count = 0;
    bool is_coarse = false;  // the budget of work was spent: rays are as exact, but take longer
    float tolerance = 0;  // how far beyond their regions faces are seen, in units

    [[nodiscard]] std::size_t bytes() const;
};

/// One face's patches, of control points about 1 in size, and what of it is there.
struct FacePatches {
    std::vector<BezierPatch> patches;
    const TrimRegion* region;
};

/// Faces reach about `tolerance` beyond their regions. Pieces that a region leaves nothing of are left out; if that is
/// all of them, there are no nodes.
[[nodiscard]] Pieces build_pieces(std::span<const FacePatches> faces, double tolerance);

struct PieceKernels {
    /// The nearest intersection with t > 0 of each ray; the primitive is the patch, u and v are its parameters, 0..1.
    void (*closest_hits)(const Pieces& pieces, std::span<const Ray> rays, Hit* hits);

    /// The unit normals at hits, turned to the rays' origins.
    void (*normals)(const Pieces& pieces, std::span<const Ray> rays, const Hit* hits, Vec3* normals);
};

BOB_DECLARE_KERNELS(PieceKernels, piece_kernels)

}  // namespace bob
