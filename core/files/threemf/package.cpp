#include "files/threemf/package.h"

#include <algorithm>
#include <vector>

#include "files/text.h"
#include "files/xml.h"

namespace bob::files::threemf {
namespace {

/// A part's name in lower case, from the root, without "." and "..".
std::string plain(std::string_view path) {
    std::string name = lower(path);
    std::ranges::replace(name, '\\', '/');
    std::vector<std::string_view> folders;
    for (std::string_view rest = name; !rest.empty();) {
        const std::string_view folder = rest.substr(0, rest.find('/'));
        rest.remove_prefix(std::min(folder.size() + 1, rest.size()));
        if (folder == "..") {
            if (!folders.empty()) folders.pop_back();
        } else if (!folder.empty() && folder != ".") {
            folders.push_back(folder);
        }
    }
    std::string result;
    for (const std::string_view folder : folders) result.append("/").append(folder);
    return result;
}

}  // namespace

Package::Package(Bytes bytes) : zip_(bytes) {
    const std::vector<ZipEntry>& entries = zip_.entries();
    for (std::size_t i = 0; i < entries.size(); ++i) parts_.insert_or_assign(plain(unescaped(entries[i].name)), i);
    for (std::size_t i = 0; i < entries.size(); ++i) parts_.insert_or_assign(plain(entries[i].name), i);
}

std::optional<std::size_t> Package::part(std::string_view path) const {
    for (const std::string& name : {plain(path), plain(unescaped(path))}) {
        if (const auto found = parts_.find(name); found != parts_.end()) return found->second;
    }
    return std::nullopt;
}

std::optional<std::size_t> Package::root() {
    if (const auto relations = part("_rels/.rels")) {
        const Numbers<std::uint8_t> text = unpacked("relationships", *relations);
        std::optional<std::string> target;
        Xml xml(text);
        for (auto event = xml.next(); event != Xml::Event::finish; event = xml.next()) {
            const XmlAttributes& get = xml.attributes();
            const bool is_model = event == Xml::Event::start && get.get("Type").ends_with("/3dmodel") && get.get("TargetMode", "Internal") == "Internal";
            if (is_model && !target) target = get.get("Target");
        }
        if (const auto found = target ? part(*target) : std::nullopt) return found;
    }
    if (const auto usual = part("3D/3dmodel.model")) return usual;
    const auto found = std::ranges::find_if(zip_.entries(), [](const ZipEntry& entry) { return lower(entry.name).ends_with(".model"); });
    if (found == zip_.entries().end()) return std::nullopt;
    return static_cast<std::size_t>(found - zip_.entries().begin());
}

Numbers<std::uint8_t> Package::unpacked(std::string_view content, std::size_t part) {
    const ZipEntry& entry = zip_.entries()[part];
    std::uint64_t& total = unpacked_[std::string(content)];
    total += std::min(entry.size, ~std::uint64_t{} - total);
    // Coordinates shrink to a third or a tenth of their text, pictures not at all, only bombs to a hundredth.
    if (total > std::uint64_t{1} << 26 && (total - 1) / 100 >= zip_.size()) {
        refuse({"expected ", content, ", got a zip file that unpacks to ", grouped(total), " bytes"});
    }
    return zip_.unpacked(entry);
}

}  // namespace bob::files::threemf
