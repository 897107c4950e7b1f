/// Draco's predictions of integers by those before them.
#pragma once

#include "files/draco/attributes.h"
#include "files/draco/walk.h"

namespace bob::files::draco {

/// The integer positions that predictions use.
struct Positions {
    const Sequence* sequence = nullptr;
    const Attribute* attribute = nullptr;
};

/// Adds the prediction of each of an attribute's values, by a method's number, to its correction.
void add_predictions(Stream& stream, int method, Attribute& attribute, const Sequence& sequence, const Positions& positions);

}  // namespace bob::files::draco
