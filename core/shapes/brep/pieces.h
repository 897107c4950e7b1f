/// Bezier patches, cut into pieces for ray intersection.
///
/// A piece is flat enough for Newton's method, and a ray intersects it at most once, unless it is nearly tangent.
/// (Abert, Geimer and Mueller, "Direct and Fast Ray Tracing of NURBS Surfaces", 2006, start Newton's method in the same
/// way, without the proof that there is no second hit.)
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

/// A Bezier patch in float32, relative to its own centre, so that small patches keep their precision.
struct Patch {
    float center[3];
    std::uint32_t control_points;  // offset of the first: (w x, w y, w z, w) each, v fastest
    std::uint16_t degree_u, degree_v;
    std::uint32_t degrees;  // index of the pair of degrees among all patches
    std::uint32_t face;
    const TrimRegion* region;  // of the face, in the face's parameters
    Domain domain;             // the face's parameters for the patch's 0..1
    float margin_u, margin_v;  // how far the face extends past its region

    /// The face's parameters at parameters 0..1 of the patch.
    [[nodiscard]] double face_u(double u) const { return domain.low_u + u * (domain.high_u - domain.low_u); }
    [[nodiscard]] double face_v(double v) const { return domain.low_v + v * (domain.high_v - domain.low_v); }

    /// Coverage of a rectangle of the face's parameters. Adds the number of visited region nodes.
    [[nodiscard]] TrimRegion::Coverage coverage(const Domain& rectangle, std::size_t* visited = nullptr) const;

    /// A rectangle around the visible part of a rectangle, both in the face's parameters; low > high if empty.
    [[nodiscard]] Domain extent(const Domain& rectangle, std::size_t* visited = nullptr) const;

    /// Coverage at parameters 0..1 of the patch: `some` if outside the region but within the margin.
    [[nodiscard]] TrimRegion::Coverage coverage(double u, double v) const;
};

/// Coverage of a trimmed piece: a grid of squares in its parameters.
struct TrimCells {
    static constexpr int side = 8;

    std::uint64_t seen = 0, crossed = 0;  // bit side * v + u: the square is fully visible; the square needs a test of the curves

    /// Coverage at parameters 0..1 of the piece; `some` if the curves decide.
    [[nodiscard]] TrimRegion::Coverage at(float u, float v) const {
        const auto index = [](float x) { return static_cast<std::uint64_t>(x * side); };
        if (!(u >= 0 && u < 1 && v >= 0 && v < 1)) return TrimRegion::Coverage::some;
        const std::uint64_t bit = std::uint64_t{1} << (side * index(v) + index(u));
        return crossed & bit ? TrimRegion::Coverage::some : seen & bit ? TrimRegion::Coverage::all : TrimRegion::Coverage::none;
    }
};

/// 704 bytes. A piece lies in a box whose x and y axes follow its u and v. In the box, to_box * (p, 1) has |x| and |y|
/// up to `half` and |z| up to 1; the parameters there are about low + (0.5 + 0.5 (x, y)) size of the patch. No ray
/// enters the box of an absent piece.
struct alignas(32) PiecePacket {
    static constexpr std::uint32_t no_trim = 0xffffffff;

    float to_box[3][4][8];
    float half[2][8];
    float lean[2][8];  // a ray may intersect the piece twice only if its direction has |z| <= lean[0] |x| + lean[1] |y|
    float low[2][8], size[2][8];
    std::uint32_t patch[8], trim[8];  // and, if the face's region crosses the piece, its cells
};

struct Pieces {
    std::vector<Patch> patches;
    std::vector<std::array<float, 4>> control_points;
    std::uint32_t pairs_of_degrees = 0;
    std::vector<BvhNode> nodes;
    std::vector<PiecePacket> packets;
    std::vector<TrimCells> trims;
    std::size_t count = 0;
    bool is_coarse = false;  // the build budget was exhausted: rays are as exact, but slower
    float tolerance = 0;  // how far faces extend past their regions, in units

    [[nodiscard]] std::size_t bytes() const;
};

/// One face's patches, with control points about 1 in size, and its region.
struct FacePatches {
    std::vector<BezierPatch> patches;
    const TrimRegion* region;
};

/// Faces extend about `tolerance` past their regions. Pieces outside their region are dropped; if no piece remains,
/// there are no nodes.
[[nodiscard]] Pieces build_pieces(std::span<const FacePatches> faces, double tolerance);

struct PieceKernels {
    /// The nearest intersection with t > 0 of each ray. The primitive is the patch, u and v are its parameters, 0..1.
    void (*closest_hits)(const Pieces& pieces, std::span<const Ray> rays, Hit* hits);

    /// The unit normals at hits, along dS/du x dS/dv.
    void (*normals)(const Pieces& pieces, std::span<const Hit> hits, Vec3* normals);
};

BOB_DECLARE_KERNELS(PieceKernels, piece_kernels)

}  // namespace bob
