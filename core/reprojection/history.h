/// Samples outlive their frame: what earlier pictures of a scene say about the next one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "picture/camera.h"
#include "picture/channels.h"
#include "reprojection/history_kernels.h"

namespace bob {

/// The surfaces and the empty places that earlier pictures have seen. Where a camera moves, points of the surfaces are seen
/// elsewhere: not at the centres of pixels, and perhaps behind something new. So they say what to expect in the next picture,
/// never what is known. (Walter, Drettakis, Parker, "Interactive Rendering using the Render Cache", 1999.)
class History {
public:
    /// Of pictures with the mask, depth and normals. The layout's other channels are carried as they are; but gray and colour are
    /// not where it has the instance: they are to be shaded anew.
    History(const Layout& layout, std::uint32_t height, std::uint32_t width);

    /// Takes over what was traced with a camera, planes of the layout. It takes the place of what was expected there; if that
    /// was for another camera, everything before is forgotten.
    void add(const Camera& camera, const float* planes);

    /// What is expected in the picture of a camera, in planes of the layout: the mask is 1 where something is. `off_center`,
    /// (height, width), says how far from the pixel's centre that was seen, in pixels; of emptiness, a half. Returns at how
    /// many pixels a surface is expected: 0 after a jump, of which all before says nothing and is forgotten. `finish` is called with
    /// the number of each row that was written, from several threads.
    std::size_t expect(const Camera& camera, float* planes, float* off_center, const std::function<void(int)>& finish = {});

    /// Forgets everything.
    void clear();

    [[nodiscard]] const Layout& layout() const { return layout_; }
    [[nodiscard]] std::uint32_t height() const { return height_; }
    [[nodiscard]] std::uint32_t width() const { return width_; }
    /// Bytes in use.
    [[nodiscard]] std::size_t bytes() const;

private:
    /// A disc of so many pixels around a point, squared.
    struct Disc {
        std::int32_t cell;
        std::uint32_t squared;
    };
    /// As many numbers as there may be points, and further ones up to whole vectors.
    using Column = std::vector<float>;

    [[nodiscard]] PointsIn<const float> points() const;
    [[nodiscard]] Sights sights();
    [[nodiscard]] Surfaces surfaces();
    /// Forgets points: those that were marked, and where there are more than `most` then, some that lie in the pixels of others.
    void drop(std::size_t most);
    void mark(std::size_t point);

    /// Where points are seen, and which surfaces are the nearest.
    void see(const Eye& eye);
    /// What discs say of each pixel: how near they are, and in which directions the centres of those of its surface lie.
    void cover(const Eye& eye);
    /// The discs of points that are farther apart than pixels.
    void find_far_discs();
    /// Which of the points that are not hidden is expected at each pixel.
    void choose(const Projection& before);
    /// Nothing is known to be empty any more where other parts of a point's surface may have come with it.
    void overrun(std::size_t point, const Projection& before);
    /// Where places of the picture were in the one before, if what is there is as deep as the middle of the scene.
    void see_back(const Projection& before, const Projection& projection);
    /// Which pixels of a row see past the unit sphere.
    static void find_outside(const Projection& projection, std::uint32_t row, std::vector<std::uint8_t>& outside);
    /// Where nothing was in a row, moved along.
    void expect_emptiness(const Projection& projection, std::uint32_t row);

    Layout layout_;
    std::vector<std::size_t> carried_components_, shade_components_;
    std::uint32_t height_, width_;
    BorderedGrid cells_;
    Camera camera_;  // of the last picture

    // Points: position, normal, and what is carried, each a column. A marked one is nowhere: its x is not a number.
    std::vector<Column> columns_;
    std::size_t count_ = 0, kept_ = 0;  // points, and how many of them are not marked
    std::vector<std::int32_t> cell_;    // and where the camera sees them, as `Sights`
    Column sight_depth_, sight_right_, sight_down_, off_center_, right_, down_, screen_x_, screen_y_;
    std::size_t in_picture_ = 0;  // points, also those that are turned away

    // At cells:
    std::vector<Choice> chosen_;                             // which point is expected
    Column surface_depth_, surface_right_, surface_down_;    // the nearest, as `Surfaces`
    Column nearest_;                                         // as `Covers`
    std::vector<std::int32_t> sides_;
    Column expected_right_, expected_down_;                  // as `ExpectedRow`
    std::vector<Column> shades_;                             // gray and the components of the colour, before they are smoothed
    std::vector<std::uint8_t> overrun_;

    std::vector<std::uint8_t> empty_, was_empty_;  // of each pixel, and 0 of what is outside
    Column was_row_, was_column_;                  // of every so many pixels across and down: where these were
    std::vector<std::int32_t> counts_;             // of a row of blocks: what is known in each column
    std::vector<Disc> far_discs_;
    std::vector<std::uint32_t> traced_;            // pixels
};

}  // namespace bob
