#include "files/binary.h"

#include "base/interruption.h"

namespace bob::files {

void read_floats(const std::uint8_t* from, std::size_t stride, std::size_t rows, double* to, std::size_t width) {
    for (std::size_t row = 0; row < rows; ++row, from += stride, to += width) {
        if (row % 65536 == 0) Interruption::check();
        *to = static_cast<double>(load<float>(from, false));
    }
}

std::size_t read_triples(Bytes bytes, std::size_t rows, bool is_big, std::int32_t* to) {
    constexpr std::size_t size = 13;
    rows = std::min(rows, bytes.size() / size);
    const std::uint8_t* from = bytes.data();
    std::size_t row = 0;
    for (; row < rows && from[0] == 3; ++row, from += size, to += 3) {
        if (row % 65536 == 0) Interruption::check();
        for (std::size_t k = 0; k < 3; ++k) to[k] = std::max(load<std::int32_t>(from + 1 + 4 * k, is_big), -1);
    }
    return row;
}

}  // namespace bob::files
