/// Reprojection: samples of earlier pictures reused for the next one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "picture/camera.h"
#include "picture/channels.h"
#include "reprojection/history_kernels.h"

namespace bob {

/// The surface samples and background pixels of earlier pictures.
///
/// After the camera moves, reprojected samples lie off pixel centres and may be occluded by surfaces not seen before.
/// So they predict the next picture and never replace traced pixels. (Walter, Drettakis, Parker, "Interactive Rendering
/// using the Render Cache", 1999.)
class History {
public:
    /// The layout has the mask, depth and normals. Its other channels are copied unchanged; but with an instance
    /// channel, gray and colour are left out, since they are shaded again.
    History(const Layout& layout, std::uint32_t height, std::uint32_t width);

    /// Adds the traced pixels of a camera, planes of the layout. They replace reprojected samples. If those belong to
    /// another camera, the history is cleared first.
    void add(const Camera& camera, const float* planes);

    /// Reprojects the history into a camera's picture, planes of the layout.
    ///
    /// The mask is 1 where there is a sample. `off_center`, (height, width), is the distance of the sample from the
    /// pixel's centre, in pixels; for background, 0.5. Returns the number of pixels with a surface sample. After a jump
    /// of the camera the history is useless: it is cleared, and the result is 0. `finish` is called with the number of
    /// each finished row, from several threads.
    std::size_t expect(const Camera& camera, float* planes, float* off_center, const std::function<void(int)>& finish = {});

    void clear();

    [[nodiscard]] const Layout& layout() const { return layout_; }
    [[nodiscard]] std::uint32_t height() const { return height_; }
    [[nodiscard]] std::uint32_t width() const { return width_; }
    /// Bytes in use.
    [[nodiscard]] std::size_t bytes() const;

private:
    /// A disc around a point; its radius squared, in pixels.
    struct Disc {
        std::int32_t cell;
        std::uint32_t squared;
    };
    /// One number for each point, padded to whole vectors.
    using Column = std::vector<float>;

    [[nodiscard]] PointsIn<const float> points() const;
    [[nodiscard]] Sights sights();
    [[nodiscard]] Surfaces surfaces();
    /// Removes marked points and, if more than `max_points` remain, some that share a pixel with others.
    void drop(std::size_t max_points);
    void mark(std::size_t point);

    /// Projects the points, and finds the nearest surface of each cell.
    void see(const Eye& eye);
    /// Splats the discs: for each cell, the nearest depth and the directions to the disc centres of its surface.
    void cover(const Eye& eye);
    /// Finds discs of points farther apart than neighbouring pixels.
    void find_far_discs();
    /// Chooses a visible point for each pixel.
    void choose(const Projection& before);
    /// Clears the background around a point: other parts of its surface may have moved there too.
    void overrun(std::size_t point, const Projection& before);
    /// Projects places of this picture into the last one, at the depth of the scene's centre.
    void see_back(const Projection& before, const Projection& projection);
    /// Finds pixels of a row whose rays miss the unit sphere.
    static void find_outside(const Projection& projection, std::uint32_t row, std::vector<std::uint8_t>& outside);
    /// Reprojects the background of a row.
    void expect_emptiness(const Projection& projection, std::uint32_t row);

    Layout layout_;
    std::vector<std::size_t> carried_components_, shade_components_;
    std::uint32_t height_, width_;
    BorderedGrid cells_;
    Camera camera_;  // of the last picture

    // Points: position, normal and the copied channels, each a column. The x of a marked point is NaN.
    std::vector<Column> columns_;
    std::size_t count_ = 0, kept_ = 0;  // all points, and the unmarked ones
    std::vector<std::int32_t> cell_;    // cells and projections of points, as `Sights`
    Column sight_depth_, sight_right_, sight_down_, off_center_, right_, down_, screen_x_, screen_y_;
    std::size_t in_picture_ = 0;  // points, including back faces

    // At cells:
    std::vector<Choice> chosen_;                             // the chosen point
    Column surface_depth_, surface_right_, surface_down_;    // the nearest surface, as `Surfaces`
    Column nearest_;                                         // as `Covers`
    std::vector<std::int32_t> sides_;
    Column expected_right_, expected_down_;                  // as `ExpectedRow`
    std::vector<Column> shades_;                             // gray and the components of the colour, before smoothing
    std::vector<std::uint8_t> overrun_;

    std::vector<std::uint8_t> empty_, was_empty_;  // background pixels; 0 outside the picture
    Column was_row_, was_column_;                  // positions in the last picture, every `piece` pixels across and down
    std::vector<std::int32_t> counts_;             // known pixels in each column of a row of blocks
    std::vector<Disc> far_discs_;
    std::vector<std::uint32_t> traced_;            // pixels
};

}  // namespace bob
