/// Collects the features of a file that are not shown.
#pragma once

#include <set>
#include <string>
#include <string_view>

#include "files/part.h"

namespace bob::files {

class NotShown {
public:
    void add(std::string_view name);

    /// Adds a warning of all names. Throws std::invalid_argument if a file has no triangles but these features.
    void report(Contents& contents, bool has_triangles) const;

private:
    std::set<std::string, std::less<>> names_;
};

}  // namespace bob::files
