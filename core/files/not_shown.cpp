#include "files/not_shown.h"

#include "files/text.h"

namespace bob::files {

void NotShown::add(std::string_view name) { names_.emplace(name); }

void NotShown::report(Contents& contents, bool has_triangles) const {
    if (names_.empty()) return;
    std::string names;
    for (const std::string& name : names_) names += (names.empty() ? "not shown: " : ", ") + name;
    if (!has_triangles) refuse({"expected triangles, got none; ", names});
    contents.warnings.push_back(std::move(names));
}

}  // namespace bob::files
