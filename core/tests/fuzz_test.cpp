/// The targets of core/fuzz, each with the inputs of its corpus: what once went wrong, and a way to every part of the code.
#include "fuzz/fuzz.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "check.h"

namespace {

std::vector<std::uint8_t> bytes_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

void replay(const char* name, void (*target)(fuzz::Source)) {
    int inputs = 0;
    for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(BOB_CORPUS) / name)) {
        const std::vector<std::uint8_t> bytes = bytes_of(entry.path());
        const auto fail = [&](const std::string& what) {
            test::fail(__FILE__, __LINE__, entry.path().filename().string() + ": " + what);
        };
        ++inputs;
        try {
            target(fuzz::Source(bytes));
        } catch (const fuzz::Broken& broken) {
            fail(std::string("expected ") + broken.what);
        } catch (const std::exception& error) {
            fail(std::string("did not expect the exception ") + error.what());
        }
    }
    CHECK_LT(0, inputs);
}

}  // namespace

fuzz::Register::Register(const char* name, void (*run)(Source)) {
    test::cases().push_back({name, [=] { replay(name, run); }});
}
