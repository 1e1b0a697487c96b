#pragma once
// A check of option values.

#include <CLI/CLI.hpp>

namespace retractor::ui::cli {

/// Accepts a number from low to high. Unlike CLI::Range, this validator refuses NaN.
CLI::Validator in_range(double low, double high);

} // namespace retractor::ui::cli
