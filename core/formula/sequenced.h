/// Rejects formulas whose node numbers would depend on the compiler.
///
/// C++ does not define which operand of a * b + c * d is computed first. A graph numbers its nodes in order of
/// creation, and commutative ops keep the older operand first. So where two operands both make nodes, the first to be
/// made gets a name. Files written with this header compile to the same formulas, and digests, everywhere:
///
///     const Value right = c * d;
///     return a * b + right;
#pragma once

#include "formula/expression.h"

namespace bob {

Value operator+(Value&&, Value&&) = delete;
Value operator-(Value&&, Value&&) = delete;
Value operator*(Value&&, Value&&) = delete;
Value operator/(Value&&, Value&&) = delete;
Value min(Value&&, Value&&) = delete;
Value max(Value&&, Value&&) = delete;
Value hypot(Value&&, Value&&) = delete;
Value atan2(Value&&, Value&&) = delete;
Value modulo(Value&&, Value&&) = delete;
Value select(Value&&, Value&&, const Value&) = delete;
Value select(Value&&, const Value&, Value&&) = delete;
Value select(const Value&, Value&&, Value&&) = delete;
Value select(Value&&, Value&&, Value&&) = delete;
Value piecewise(Value&&, Value&&, const Value&) = delete;
Value piecewise(Value&&, const Value&, Value&&) = delete;
Value piecewise(const Value&, Value&&, Value&&) = delete;
Value piecewise(Value&&, Value&&, Value&&) = delete;

}  // namespace bob
