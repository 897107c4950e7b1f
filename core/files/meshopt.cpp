#include "files/meshopt.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <tuple>
#include <type_traits>
#include <utility>

#include "base/interruption.h"
#include "files/binary.h"
#include "files/text.h"

namespace bob::files {
namespace {

using Buffer = std::vector<std::uint8_t>;

constexpr std::size_t max_stride = 256, max_block = 256, group = 16;

[[noreturn]] void refuse_stride(std::size_t stride) { refuse({"byteStride: expected one that its mode and filter allow, got ", std::to_string(stride)}); }

void check_start(Stream& stream, std::uint8_t expected) {
    if (stream.number() != expected) refuse({"expected compressed data of a known version, got another"});
}

void check_end(const Stream& stream, std::size_t expected) {
    if (stream.size() != expected) refuse({"expected compressed data for its count, got more"});
}

/// Reads 16 deltas of `bits` bits each. The largest of them announces a whole byte.
void read_group(Stream& stream, int bits, std::uint8_t* to) {
    if (bits == 0) {
        std::fill_n(to, group, std::uint8_t{0});
    } else if (bits == 8) {
        std::ranges::copy(stream.take(group), to);
    } else {
        const Bytes packed = stream.take(group * static_cast<std::size_t>(bits) / 8);
        const std::size_t in_byte = 8 / static_cast<std::size_t>(bits);
        const int escape = (1 << bits) - 1;
        for (std::size_t i = 0; i < group; ++i) {
            const std::size_t at = i % in_byte;
            // Single bits start at the lowest, all others at the highest.
            const std::size_t shift = static_cast<std::size_t>(bits) * (bits == 1 ? at : in_byte - 1 - at);
            const int value = packed[i / in_byte] >> shift & escape;
            to[i] = value == escape ? stream.number() : static_cast<std::uint8_t>(value);
        }
    }
}

/// Adds deltas to the elements before them, four bytes of each at a time.
///
/// channel: of these bytes, in the codec's version 1. deltas: (4, max_block), byte by byte. last: the element before.
void add_deltas(std::uint8_t channel, const std::uint8_t* deltas, std::size_t count, std::uint8_t* last, std::uint8_t* to, std::size_t stride) {
    const auto pair = [&](std::size_t k, std::size_t i) { return deltas[k * max_block + i] | deltas[(k + 1) * max_block + i] << 8; };
    for (std::size_t i = 0; i < count; ++i) {
        if (channel % 4 == 0) {
            for (std::size_t k = 0; k < 4; ++k) last[k] = static_cast<std::uint8_t>(last[k] + unzigzagged(deltas[k * max_block + i]));
        } else if (channel % 4 == 1) {
            for (std::size_t k = 0; k < 4; k += 2) {
                const auto value = static_cast<std::uint16_t>(load<std::uint16_t>(last + k, false) + unzigzagged(static_cast<std::uint16_t>(pair(k, i))));
                std::memcpy(last + k, &value, 2);
            }
        } else {
            const auto change = static_cast<std::uint32_t>(pair(0, i)) | static_cast<std::uint32_t>(pair(2, i)) << 16;
            const std::uint32_t value = load<std::uint32_t>(last, false) ^ std::rotr(change, channel >> 4);
            std::memcpy(last, &value, 4);
        }
        std::memcpy(to + i * stride, last, 4);
    }
}

Buffer vertices(Bytes from, std::size_t count, std::size_t stride) {
    if (stride % 4 || stride == 0 || stride > max_stride) refuse_stride(stride);
    const bool is_first_version = !from.empty() && from[0] == 0xa0;
    const std::size_t words = stride / 4, tail = is_first_version ? stride : stride + words;
    const std::size_t padded = std::max<std::size_t>(tail, is_first_version ? 32 : 24);
    Stream stream(from);
    check_start(stream, is_first_version ? 0xa0 : 0xa1);
    if (stream.size() < padded) refuse({"expected more compressed data, got its end"});
    const Bytes channels = is_first_version ? Bytes() : from.last(words);
    if (std::ranges::any_of(channels, [](std::uint8_t channel) { return channel % 4 == 3; })) refuse({"expected known kinds of channels, got another"});
    std::array<std::uint8_t, max_stride> last{};
    std::ranges::copy(from.last(tail).first(stride), last.begin());

    Buffer result(count * stride);
    std::vector<std::uint8_t> deltas(stride * max_block);
    const std::size_t block = std::min(8192 / stride / group * group, max_block);
    for (std::size_t start = 0; start < count; start += block) {
        Interruption::check();
        const std::size_t size = std::min(block, count - start), groups = (size + group - 1) / group;
        const Bytes controls = is_first_version ? Bytes() : stream.take(words);
        for (std::size_t k = 0; k < stride; ++k) {
            std::uint8_t* const to = &deltas[k * max_block];
            const int control = is_first_version ? -1 : controls[k / 4] >> (k % 4 * 2) & 3;
            if (control == 2) {
                std::fill_n(to, size, std::uint8_t{0});
            } else if (control == 3) {
                std::ranges::copy(stream.take(size), to);
            } else {
                constexpr int widths[][4] = {{0, 2, 4, 8}, {0, 1, 2, 4}, {1, 2, 4, 8}};
                const Bytes modes = stream.take((groups + 3) / 4);
                for (std::size_t i = 0; i < groups; ++i) read_group(stream, widths[control + 1][modes[i / 4] >> (i % 4 * 2) & 3], to + i * group);
            }
        }
        for (std::size_t k = 0; k < stride; k += 4) {
            add_deltas(channels.empty() ? 0 : channels[k / 4], &deltas[k * max_block], size, &last[k], &result[start * stride + k], stride);
        }
    }
    check_end(stream, padded);
    return result;
}

/// Unsigned integers of 2 or 4 bytes.
class Indices {
public:
    Indices(std::size_t count, std::size_t stride) : stride_(stride) {
        if (stride != 2 && stride != 4) refuse_stride(stride);
        bytes_.resize(count * stride);
    }
    void push(std::uint32_t index) {
        std::memcpy(&bytes_[at_], &index, stride_);
        at_ += stride_;
    }
    [[nodiscard]] Buffer bytes() && { return std::move(bytes_); }

private:
    std::size_t stride_, at_ = 0;
    Buffer bytes_;
};

/// The latest values; the newest has number 0.
template <class T>
class Latest {
public:
    T operator[](std::size_t number) const { return values_[(next_ - 1 - number) % values_.size()]; }
    void push(T value) { values_[next_++ % values_.size()] = value; }

private:
    std::array<T, 16> values_{};
    std::size_t next_ = 0;
};

Buffer triangle_list(Bytes from, std::size_t count, std::size_t stride) {
    if (count % 3) refuse({"count: expected three indices for each triangle, got ", std::to_string(count)});
    constexpr std::size_t pairs = 16;
    Stream stream(from);
    check_start(stream, 0xe1);
    const Bytes codes = stream.take(count / 3);
    if (stream.size() < pairs) refuse({"expected more compressed data, got its end"});
    Indices result(count, stride);
    Latest<std::pair<std::uint32_t, std::uint32_t>> edges;
    Latest<std::uint32_t> latest;
    std::uint32_t next = 0, last = 0;
    const auto decoded = [&] { return last += unzigzagged(stream.varint()); };
    const auto is_new = [](int code) { return code == 0 || code == 15; };
    const auto corner = [&](int code) { return code == 0 ? next++ : code == 15 ? decoded() : latest[static_cast<std::size_t>(code - 1)]; };
    for (std::size_t i = 0; i < codes.size(); ++i) {
        if (i % 65536 == 0) Interruption::check();
        const int high = codes[i] >> 4, low = codes[i] & 15;
        std::uint32_t a = 0, b = 0, c = 0;
        if (high < 15) {
            std::tie(a, b) = edges[static_cast<std::size_t>(high)];
            c = low == 0 ? next++ : low < 13 ? latest[static_cast<std::size_t>(low)] : low == 13 ? --last : low == 14 ? ++last : decoded();
            if (low == 0 || low >= 13) latest.push(c);
        } else {
            const int pair = low < 14 ? from[from.size() - pairs + static_cast<std::size_t>(low)] : stream.number();
            if (low >= 14 && pair == 0) next = 0;
            a = low < 15 ? next++ : decoded();
            b = corner(pair >> 4);
            c = corner(pair & 15);
            latest.push(a);
            if (is_new(pair >> 4)) latest.push(b);
            if (is_new(pair & 15)) latest.push(c);
            edges.push({b, a});
        }
        edges.push({c, b});
        edges.push({a, c});
        for (const std::uint32_t index : {a, b, c}) result.push(index);
    }
    check_end(stream, pairs);
    return std::move(result).bytes();
}

Buffer sequence(Bytes from, std::size_t count, std::size_t stride) {
    constexpr std::size_t tail = 4;
    Stream stream(from);
    check_start(stream, 0xd1);
    if (stream.size() < tail || stream.size() - tail < count) refuse({"expected more compressed data, got its end"});
    Indices result(count, stride);
    std::array<std::uint32_t, 2> last{};
    for (std::size_t i = 0; i < count; ++i) {
        if (i % 65536 == 0) Interruption::check();
        const std::uint32_t code = stream.varint();
        result.push(last[code & 1] += unzigzagged(code >> 1));
    }
    check_end(stream, tail);
    return std::move(result).bytes();
}

/// The nearest integer of a type; 0 of NaN.
template <class T>
T rounded(double value) {
    using Limits = std::numeric_limits<T>;
    return std::isnan(value) ? T{0} : static_cast<T>(std::lround(std::clamp<double>(value, Limits::min(), Limits::max())));
}

/// Calls f with each element's four integers of a type.
template <class T, class F>
void for_each_four(Buffer& bytes, F f) {
    for (std::size_t at = 0; at + 4 * sizeof(T) <= bytes.size(); at += 4 * sizeof(T)) {
        std::array<T, 4> four;
        std::memcpy(four.data(), &bytes[at], sizeof four);
        f(four);
        std::memcpy(&bytes[at], four.data(), sizeof four);
    }
}

/// Unit vectors on an octahedron; the third number is the scale.
template <class T>
void unfold_normals(Buffer& bytes) {
    for_each_four<T>(bytes, [](std::array<T, 4>& four) {
        double x = static_cast<double>(four[0]) / four[2], y = static_cast<double>(four[1]) / four[2];
        const double z = 1 - std::fabs(x) - std::fabs(y), fold = std::max(-z, 0.0);
        x -= std::copysign(fold, x);
        y -= std::copysign(fold, y);
        const double scale = std::numeric_limits<T>::max() / std::sqrt(x * x + y * y + z * z);
        four = {rounded<T>(x * scale), rounded<T>(y * scale), rounded<T>(z * scale), four[3]};
    });
}

/// Unit quaternions without their largest number, which the last two bits name.
void complete_quaternions(Buffer& bytes) {
    for_each_four<std::int16_t>(bytes, [](std::array<std::int16_t, 4>& four) {
        const auto largest = static_cast<std::size_t>(four[3] & 3);
        const double scale = 1 / (std::numbers::sqrt2 * (four[3] | 3));
        std::array<double, 4> rest = {0, four[0] * scale, four[1] * scale, four[2] * scale};
        rest[0] = std::sqrt(std::max(1 - rest[1] * rest[1] - rest[2] * rest[2] - rest[3] * rest[3], 0.0));
        for (std::size_t i = 0; i < 4; ++i) four[(largest + i) % 4] = rounded<std::int16_t>(rest[i] * 32767);
    });
}

/// Floats as an exponent of 8 bits and a mantissa of 24, both signed.
void scale_by_exponents(Buffer& bytes) {
    for (std::size_t at = 0; at < bytes.size(); at += 4) {
        const auto stored = load<std::int32_t>(&bytes[at], false);
        const auto value = static_cast<float>(std::ldexp((stored << 8) >> 8, stored >> 24));
        std::memcpy(&bytes[at], &value, 4);
    }
}

/// Colours as luma, orange and green differences, and alpha, whose highest bit gives the scale. T is unsigned.
template <class T>
void unmix_colors(Buffer& bytes) {
    for_each_four<T>(bytes, [](std::array<T, 4>& four) {
        const int luma = four[0], orange = static_cast<std::make_signed_t<T>>(four[1]), green = static_cast<std::make_signed_t<T>>(four[2]);
        const unsigned bits = std::bit_width(static_cast<unsigned>(four[3])), most = (1u << bits) - 1;
        const double scale = static_cast<double>(std::numeric_limits<T>::max()) / most;
        const unsigned alpha = four[3] & (most >> 1);
        four = {rounded<T>((luma + orange - green) * scale), rounded<T>((luma + green) * scale), rounded<T>((luma - orange - green) * scale),
                rounded<T>((alpha << 1 | (alpha & 1)) * scale)};
    });
}

void unfilter(Buffer& bytes, std::size_t stride, std::string_view filter) {
    if (filter == "NONE") return;
    const bool is_narrow = stride == 4;
    if (filter == "EXPONENTIAL") return scale_by_exponents(bytes);
    if (stride != 8 && !(is_narrow && filter != "QUATERNION")) refuse_stride(stride);
    if (filter == "OCTAHEDRAL") return is_narrow ? unfold_normals<std::int8_t>(bytes) : unfold_normals<std::int16_t>(bytes);
    if (filter == "QUATERNION") return complete_quaternions(bytes);
    if (filter == "COLOR") return is_narrow ? unmix_colors<std::uint8_t>(bytes) : unmix_colors<std::uint16_t>(bytes);
    refuse({"filter: expected one of the extension's, got ", quoted(filter)});
}

}  // namespace

std::vector<std::uint8_t> meshopt_decoded(Bytes from, std::size_t count, std::size_t stride, std::string_view mode, std::string_view filter) {
    if (mode == "TRIANGLES") return triangle_list(from, count, stride);
    if (mode == "INDICES") return sequence(from, count, stride);
    if (mode != "ATTRIBUTES") refuse({"mode: expected ATTRIBUTES, TRIANGLES or INDICES, got ", quoted(mode)});
    Buffer result = vertices(from, count, stride);
    unfilter(result, stride, filter);
    return result;
}

}  // namespace bob::files
