/// SHA-256, and digests of shapes.
#include "tracing/canonical.h"

#include <cstring>

#include "check.h"

namespace {

std::string hex(const bob::Digest& digest) {
    std::string text;
    for (const std::uint8_t byte : digest) {
        text += "0123456789abcdef"[byte >> 4];
        text += "0123456789abcdef"[byte & 15];
    }
    return text;
}

bool is(const bob::Digest& digest, const char* wanted) {
    if (hex(digest) != wanted) test::fail(__FILE__, __LINE__, hex(digest));
    return true;
}

}  // namespace

TEST(sha256_of_the_standard_s_examples) {
    const auto of = [](std::string_view text) { return bob::Sha256().update(text).digest(); };
    is(of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    is(of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    is(of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
       "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    is(of(std::string(1'000'000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(sha256_does_not_depend_on_how_bytes_come) {
    std::string text;
    for (int i = 0; i < 300; ++i) text += static_cast<char>(i * 7);
    for (std::size_t size = 0; size <= text.size(); ++size) {
        const std::string_view all = std::string_view(text).substr(0, size);
        const auto wanted = hex(bob::Sha256().update(all).digest());
        for (const std::size_t step : {std::size_t{1}, std::size_t{63}, std::size_t{64}, std::size_t{65}}) {
            bob::Sha256 hash;
            for (std::size_t at = 0; at < size; at += step) hash.update(all.substr(at, step));
            CHECK(hex(hash.digest()) == wanted);
        }
    }
}

TEST(digests_of_shapes_and_instances_are_of_the_text_that_files_know) {
    const double numbers[] = {1.5, -2};
    const auto bytes = std::as_bytes(std::span(numbers));
    bob::ShapeDigest shape("tube");
    shape.add({"a", "<f8", {2}, bytes});
    shape.add({"b", "<f8", {1, 2}, bytes});
    shape.add("c", "text");
    const auto wanted = bob::Sha256().update("tubea <f8 (2,)").update(bytes).update("b <f8 (1, 2)").update(bytes)
                            .update("c text").digest();
    CHECK(shape.digest() == wanted);
    double seen[16 + 7] = {};
    for (int i = 0; i < 23; ++i) seen[i] = i;
    seen[12] = seen[13] = seen[14] = 0, seen[15] = 1;
    bob::AffineMap transform;
    std::copy_n(seen, 12, &transform.row[0][0]);
    const bob::Material material{{16, 17, 18}, 19, 20, 21, 22};
    CHECK(bob::instance_digest(wanted, transform, material) ==
          bob::Sha256().update(std::as_bytes(std::span(wanted))).update(std::as_bytes(std::span(seen))).digest());
}

TEST(canonical_order_is_by_bytes_and_stable) {
    bob::Digest low{}, high{}, last{};
    low[31] = 255, high[30] = 1, last[0] = 200;
    const bob::Digest digests[] = {last, high, low, high};
    const auto order = bob::canonical_order(digests);
    CHECK(order == (std::vector<std::uint32_t>{2, 1, 3, 0}));
}
