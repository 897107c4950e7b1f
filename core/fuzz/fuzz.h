/// A target is a function that takes bytes, makes of them what comes through one of the core's doors, and must end: without
/// an exception that the door does not promise, and with what it expects being so.
///
/// libFuzzer calls one target with bytes of its own (libfuzzer.cpp), the core's tests call all of them with the bytes in
/// corpus/TARGET (core/tests/fuzz_test.cpp).
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <span>
#include <string_view>

namespace fuzz {

/// Numbers and choices out of an input, from its beginning to its end; zeros after that.
class Source {
public:
    explicit Source(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    [[nodiscard]] bool empty() const { return bytes_.empty(); }

    /// The bytes of a T.
    template <class T>
    T raw() {
        T value{};
        const std::size_t count = bytes_.size() < sizeof value ? bytes_.size() : sizeof value;
        if (count) std::memcpy(&value, bytes_.data(), count);
        bytes_ = bytes_.subspan(count);
        return value;
    }

    std::uint8_t byte() { return raw<std::uint8_t>(); }
    bool flag() { return byte() & 1; }

    /// 0..count-1, of at most 256.
    std::uint32_t below(std::uint32_t count) { return byte() % count; }
    int between(int low, int high) { return low + static_cast<int>(below(static_cast<std::uint32_t>(high - low + 1))); }

    /// Any number: often of everyday size, sometimes where arithmetic goes wrong.
    double number() {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        constexpr double special[] = {0, 1, -1, 0.5, -0.5, 2, 3, -0.0, 1e-3, 1e-7, 1e-20, 1e-45, 0x1p-149, 1e-100, 1e-300, 5e-324,
                                      10, 100, 1e3, 1e4, 1e6, 1e9, -1e9, 0x1p24, 1e30, 3e38, 1e39, 1e100, -1e100, 1e300, infinity,
                                      -infinity};
        const std::uint8_t kind = byte();
        if (kind < std::size(special)) return special[kind];
        if (kind == 32) return std::numeric_limits<double>::quiet_NaN();
        if (kind == 33) return raw<double>();
        if (kind == 34) return raw<float>();
        return static_cast<double>((kind * 256 + byte()) - (146 * 256)) / 8192;  // within -3.5..3.5
    }

    /// Between two numbers, in 65536 steps.
    double within(double low, double high) { return low + (high - low) * raw<std::uint16_t>() / 65535; }

    /// What is left.
    [[nodiscard]] std::span<const std::uint8_t> rest() const { return bytes_; }
    [[nodiscard]] std::string_view text() const { return {reinterpret_cast<const char*>(bytes_.data()), bytes_.size()}; }

private:
    std::span<const std::uint8_t> bytes_;
};

/// What a target found not to be so. No kind of the exceptions that doors promise.
struct Broken {
    const char* what;
};

inline void expect(bool holds, const char* what) {
    if (!holds) throw Broken{what};
}

/// Whether readers let a coordinate pass; NaN is none.
inline bool in_range(double value) { return std::fabs(value) <= 1e100; }

/// Says yes so many times; then long work ends by Stopped. Counted, not timed, so that an input always does the same.
struct Patience {
    int left;
    bool operator()() { return left-- > 0; }
};

/// Makes a target known to whoever calls them.
struct Register {
    Register(const char* name, void (*run)(Source));
};

}  // namespace fuzz

#define FUZZ(name)                                          \
    static void name(fuzz::Source source);                  \
    static const fuzz::Register register_##name{#name, name}; \
    static void name(fuzz::Source source)
