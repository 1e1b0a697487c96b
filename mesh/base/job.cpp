#include "mesh/base/job.h"

#include <algorithm>

namespace retractor {

void Ledger::add(BuiltPart part)
{
    const std::lock_guard lock(mutex_);
    parts_.push_back(std::move(part));
}

std::vector<BuiltPart> Ledger::parts() const
{
    const std::lock_guard lock(mutex_);
    return parts_;
}

bool Ledger::has(std::string_view name) const
{
    const std::lock_guard lock(mutex_);
    return std::any_of(parts_.begin(), parts_.end(), [&](const BuiltPart& p) { return p.name == name; });
}

void record_part(const Job& job, std::string_view name, const Stopwatch& watch, std::size_t bytes)
{
    if (job.ledger != nullptr)
        job.ledger->add({ .name = std::string(name), .seconds = watch.seconds(), .bytes = bytes });
}

} // namespace retractor
