/// Collects the features of a file that are not shown.
#pragma once

#include <set>
#include <string>
#include <string_view>

#include "files/part.h"
#include "files/text.h"

namespace bob::files {

class NotShown {
public:
    void add(std::string_view name) { names_.emplace(name); }

    /// Adds a warning of all names. Throws std::invalid_argument if a file has no triangles but these features.
    void report(Contents& contents, bool has_triangles) const {
        std::string names;
        for (const std::string& name : names_) names += (names.empty() ? "not shown: " : ", ") + name;
        if (!has_triangles && !names.empty()) refuse({"expected triangles, got none; ", names});
        if (!names.empty()) contents.warnings.push_back(std::move(names));
    }

private:
    std::set<std::string, std::less<>> names_;
};

}  // namespace bob::files
