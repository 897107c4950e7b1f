#include "files/zip.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "files/binary.h"
#include "files/inflate.h"
#include "files/text.h"

namespace bob::files {
namespace {

constexpr std::size_t end_size = 22, locator_size = 20, end64_size = 56, entry_size = 46, local_size = 30;
constexpr std::uint32_t end_mark = 0x06054b50, locator_mark = 0x07064b50, end64_mark = 0x06064b50, entry_mark = 0x02014b50, local_mark = 0x04034b50;

[[noreturn]] void refuse_zip(std::string_view why) { refuse({"expected a zip file that can be unpacked, got another (", why, ")"}); }

template <class T>
T stored(Bytes bytes, std::size_t at) {
    return load<T>(&bytes[at], false);
}

/// `size` bytes from a place on.
Bytes some(Bytes bytes, std::uint64_t at, std::uint64_t size) {
    if (at > bytes.size() || size > bytes.size() - at) refuse_zip("it ends too soon");
    return bytes.subspan(static_cast<std::size_t>(at), static_cast<std::size_t>(size));
}

/// The directory: where it is said to start, its size, and where it ends.
struct Directory {
    std::uint64_t start, size, end;
};

/// A comment of at most 64 KiB follows the last record.
Directory directory_of(Bytes bytes) {
    constexpr std::size_t most = end_size + 0xffff;
    const std::size_t first = bytes.size() > most ? bytes.size() - most : 0;
    for (std::size_t at = bytes.size() < end_size ? 0 : bytes.size() - end_size + 1; at-- > first;) {
        if (stored<std::uint32_t>(bytes, at) != end_mark) continue;
        const Directory found{stored<std::uint32_t>(bytes, at + 16), stored<std::uint32_t>(bytes, at + 12), at};
        const bool is_long = at >= locator_size && stored<std::uint32_t>(bytes, at - locator_size) == locator_mark;
        if (!is_long || at < locator_size + end64_size) return found;
        const std::size_t last = at - locator_size - end64_size;
        if (stored<std::uint32_t>(bytes, last) != end64_mark) return found;
        return {stored<std::uint64_t>(bytes, last + 48), stored<std::uint64_t>(bytes, last + 40), last};
    }
    refuse_zip("no directory at its end");
}

/// Takes the 64 bits of numbers that do not fit into 32, from an entry's extra fields.
void widen(Bytes fields, std::initializer_list<std::uint64_t*> numbers) {
    constexpr std::uint64_t too_large = 0xffffffff;
    while (fields.size() >= 4) {
        const auto kind = stored<std::uint16_t>(fields, 0);
        const std::size_t size = stored<std::uint16_t>(fields, 2);
        Bytes own = some(fields, 4, size);
        for (auto number = numbers.begin(); kind == 1 && number != numbers.end(); ++number) {
            if (**number != too_large) continue;
            **number = load<std::uint64_t>(some(own, 0, 8).data(), false);
            own = own.subspan(8);
        }
        fields = fields.subspan(4 + size);
    }
}

}  // namespace

Zip::Zip(Bytes bytes) : bytes_(bytes) {
    const Directory directory = directory_of(bytes);
    if (directory.size > directory.end) refuse_zip("its directory is damaged");
    const std::uint64_t start = directory.end - directory.size;
    if (directory.start > start) refuse_zip("its directory is damaged");
    const std::uint64_t before = start - directory.start;  // bytes that do not belong to the zip file
    Bytes rest = some(bytes, start, directory.size);
    while (!rest.empty()) {
        const Bytes head = some(rest, 0, entry_size);
        if (stored<std::uint32_t>(head, 0) != entry_mark) refuse_zip("its directory is damaged");
        const std::size_t name = stored<std::uint16_t>(head, 28), extra = stored<std::uint16_t>(head, 30), comment = stored<std::uint16_t>(head, 32);
        ZipEntry entry{.name = {}, .start = stored<std::uint32_t>(head, 42), .packed = stored<std::uint32_t>(head, 20),
                       .size = stored<std::uint32_t>(head, 24), .crc = stored<std::uint32_t>(head, 16),
                       .method = stored<std::uint16_t>(head, 10), .is_encrypted = (stored<std::uint16_t>(head, 8) & 1) != 0};
        const Bytes text = some(rest, entry_size, name);
        entry.name.assign(text.begin(), text.end());
        widen(some(rest, entry_size + name, extra), {&entry.size, &entry.packed, &entry.start});
        if (entry.start > bytes.size()) refuse_zip("it ends too soon");
        entry.start += before;
        entries_.push_back(std::move(entry));
        rest = rest.subspan(some(rest, 0, entry_size + name + extra + comment).size());
    }
}

Numbers<std::uint8_t> Zip::unpacked(const ZipEntry& entry) const {
    const Bytes head = some(bytes_, entry.start, local_size);
    if (stored<std::uint32_t>(head, 0) != local_mark) refuse_zip("its directory is damaged");
    if (entry.is_encrypted) refuse_zip("it is encrypted");
    const std::uint64_t data = entry.start + local_size + stored<std::uint16_t>(head, 26) + stored<std::uint16_t>(head, 28);
    const Bytes packed = some(bytes_, data, entry.packed);
    Numbers<std::uint8_t> result;
    if (entry.method == 8) {
        try {
            result = inflated(packed, entry.size);
        } catch (const std::invalid_argument& error) {
            refuse_zip(error.what());
        }
    } else if (entry.method == 0 && entry.packed == entry.size) {
        result.assign(packed.begin(), packed.end());
    } else {
        refuse_zip(entry.method ? "its compression is not Deflate" : "its directory is damaged");
    }
    if (crc32(result) != entry.crc) refuse_zip("a checksum differs");
    return result;
}

}  // namespace bob::files
