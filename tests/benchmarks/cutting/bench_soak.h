#pragma once
// Endurance of the knife: many short cuts in a row on one body, all of them taken back, all of them made again.

#include "ui/cli/framework/command.h"

#include <cstdint>

namespace retractor::benchmarks {

struct SoakOptions {
    int cuts = 1000;
    std::string body = "thorax"; ///< or a box: "12k", "96k", "1M"
    std::uint64_t seed = 1; ///< of the places
};

/// Cuts all over the skin, some two edges long and more than one deep, later ones across earlier ones where no room is
/// left; time and memory every tenth of the way. Exit code 1 when undo or redo is not exact, or when the time of the
/// same cut, resident memory per living element or the journal per cut or per element crossed does not stay flat.
ui::cli::Outcome soak_cut(const SoakOptions& options, const Job& job);

} // namespace retractor::benchmarks
