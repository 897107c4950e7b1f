/// Scripts of the modelling language: any bytes end in a shape or a ScriptError of one line. Small shapes are traced.
#include <cstring>

#include "formula/text.h"
#include "fuzz/formulas.h"
#include "modelling/script.h"

FUZZ(script) {
    const bool traced = source.byte() % 16 == 't' % 16;  // tracing takes a hundred times as long as running
    bob::Sdf sdf;
    try {
        sdf = bob::run_script(source.text());
    } catch (const bob::ScriptError& error) {
        fuzz::expect(!std::strpbrk(error.what(), "\r\n"), "an error of one line");
        fuzz::expect(error.at.line >= 1 && error.at.column >= 1, "an error with a place");
        return;
    }
    const bob::Expression& f = *sdf.expression;
    fuzz::expect(sdf.dimensions == 3, "a shape of three dimensions");
    fuzz::expect(bob::to_text(f).size() <= 200, "a text of the length asked for");
    if (sdf.color && sdf.color->nodes().size() < 10000) fuzz::colors(*sdf.color);
    if (!traced || f.nodes().size() > 200) return;
    if (const auto box = fuzz::bounds_of(f)) fuzz::trace(f, *box, source);
}
