/// Refuses formulas whose nodes each compiler would number in its own order. C++ leaves open which operand of a * b + c * d
/// is computed first, and a graph numbers its nodes as they come; commutative ops keep the older operand first. So where
/// two operands both make nodes, the first to be made gets a name, and files written with this header compile to the same
/// formulas, and digests, everywhere:
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
