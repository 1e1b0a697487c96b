#pragma once
// Damage to a text, as accidents and people do it: bytes changed, lost, doubled; tokens swapped for awkward ones;
// values of the document replaced, moved or nested. Deterministic for a given generator state.

#include <random>
#include <string>

namespace retractor::fuzz {

/// One random change to the bytes.
std::string damage_bytes(const std::string& text, std::mt19937_64& random);
/// One random change to a value or key of a JSON text, which stays JSON.
std::string damage_values(const std::string& text, std::mt19937_64& random);

} // namespace retractor::fuzz
