#include "files/draco/entropy.h"

#include <algorithm>

#include "base/interruption.h"
#include "files/text.h"

namespace bob::files::draco {
namespace {

constexpr std::uint32_t bits_base = 4096;

Bytes coded(Stream& stream) { return stream.take(stream.varint()); }

/// A decoder of symbols with the probabilities that precede them.
class Alphabet {
public:
    Alphabet(Stream& stream, unsigned bits, Budget& budget)
        : precision_(std::clamp(3 * bits / 2, 12u, 20u)), starts_(read(stream, budget)), ans_(coded(stream), std::uint32_t{4} << precision_) {}

    std::uint32_t next() {
        ans_.fill();
        const std::uint32_t place = ans_.state() & ((std::uint32_t{1} << precision_) - 1), symbol = symbols_[place];
        const std::uint32_t start = starts_[symbol], probability = starts_[symbol + 1] - start;
        ans_.set((ans_.state() >> precision_) * probability + place - start);
        return symbol;
    }

private:
    /// Reads the probabilities of all symbols; returns their sums.
    std::vector<std::uint32_t> read(Stream& stream, Budget& budget) {
        const std::uint32_t count = stream.varint(), total = std::uint32_t{1} << precision_;
        // A byte encodes 64 symbols that do not occur.
        if (count / 64 > stream.size()) refuse({"expected more compressed data, got its end"});
        budget.take(std::uint64_t{total} + 4 * std::uint64_t{count});
        std::vector<std::uint32_t> starts = {0};
        starts.reserve(count + std::size_t{1});
        symbols_.reserve(total);
        while (starts.size() <= count) {
            const std::uint32_t byte = stream.number(), kind = byte & 3;
            if (kind == 3) {
                starts.resize(std::min<std::size_t>(starts.size() + (byte >> 2) + 1, count + std::size_t{1}), starts.back());
                continue;
            }
            std::uint32_t probability = byte >> 2;
            for (std::uint32_t i = 0; i < kind; ++i) probability |= std::uint32_t{stream.number()} << (8 * i + 6);
            if (probability > total - starts.back()) refuse({"expected probabilities that add up to one, got others"});
            symbols_.resize(symbols_.size() + probability, static_cast<std::uint32_t>(starts.size() - 1));
            starts.push_back(starts.back() + probability);
        }
        if (starts.back() != total) refuse({"expected probabilities that add up to one, got others"});
        return starts;
    }

    unsigned precision_;
    std::vector<std::uint32_t> symbols_, starts_;  // the symbol at each place; the first place of each symbol
    Ans ans_;
};

}  // namespace

std::uint32_t Bits::read(unsigned count) {
    if (count > 32 || count > 8 * bytes_.size() - at_) refuse({"expected more compressed data, got its end"});
    std::uint32_t result = 0;
    for (unsigned i = 0; i < count; ++i, ++at_) result |= std::uint32_t{bytes_[at_ / 8] >> at_ % 8 & 1u} << i;
    return result;
}

Ans::Ans(Bytes bytes, std::uint32_t base) : base_(base) {
    const std::size_t size = bytes.empty() ? 0 : (bytes.back() >> 6) + std::size_t{1};
    if (bytes.empty() || size > bytes.size()) refuse({"expected more compressed data, got its end"});
    for (std::size_t i = 0; i < size; ++i) state_ |= std::uint32_t{bytes[bytes.size() - size + i]} << (8 * i);
    state_ = (state_ & ((std::uint32_t{1} << (8 * size - 2)) - 1)) + base;
    if (state_ >= std::uint64_t{base} * 256) refuse({"expected a state in its range, got a larger one"});
    bytes_ = bytes.first(bytes.size() - size);
}

AnsBits::AnsBits(Stream& stream) : zero_(stream.number()), ans_(coded(stream), bits_base) {}

bool AnsBits::read() {
    ans_.fill();
    const std::uint32_t one = (256u - zero_) & 255, quotient = ans_.state() >> 8, rest = ans_.state() & 255;
    const bool result = rest < one;
    ans_.set(result ? quotient * one + rest : ans_.state() - quotient * one - one);
    return result;
}

std::vector<std::uint32_t> symbols(Stream& stream, std::size_t count, std::size_t width, Budget& budget) {
    budget.take(4 * std::uint64_t{count});
    std::vector<std::uint32_t> result(count);
    if (!count) return result;
    const std::uint8_t scheme = stream.number();
    if (scheme > 1) refuse({"expected a known kind of symbols, got another"});
    const bool is_tagged = scheme == 0;
    const unsigned bits = is_tagged ? 5 : stream.number();
    if (bits < 1 || bits > 18) refuse({"expected symbols of 1 to 18 bits, got others"});
    Alphabet alphabet(stream, bits, budget);
    Bits plain(stream.rest());
    for (std::size_t i = 0; i < count; ++i) {
        if (i % 65536 == 0) Interruption::check();
        if (!is_tagged) {
            result[i] = alphabet.next();
        } else if (i % width == 0) {
            const std::uint32_t length = alphabet.next();
            for (std::size_t k = i; k < std::min(i + width, count); ++k) result[k] = plain.read(length);
        }
    }
    static_cast<void>(stream.take(plain.used()));
    return result;
}

}  // namespace bob::files::draco
