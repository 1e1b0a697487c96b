#include "haptics/device/hand_path.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>

namespace retractor::haptics {

HandPath::HandPath(std::vector<HandKey> keys)
    : keys_(std::move(keys))
{
    if (keys_.empty())
        throw InputError("a hand's path needs at least one key");
    for (std::size_t i = 0; i < keys_.size(); ++i) {
        const std::string where = "key " + std::to_string(i);
        if (!std::isfinite(keys_[i].time_s) || !keys_[i].position.allFinite())
            throw InputError("a hand's path has a number that is not finite", where);
        if (i > 0 && !(keys_[i].time_s > keys_[i - 1].time_s))
            throw InputError("the times of a hand's path do not increase", where);
    }
}

std::size_t HandPath::key_after(double time_s) const noexcept
{
    const auto after = std::upper_bound(
        keys_.begin(), keys_.end(), time_s, [](double time, const HandKey& key) { return time < key.time_s; });
    return static_cast<std::size_t>(after - keys_.begin());
}

Vec3 HandPath::position(double time_s) const noexcept
{
    const std::size_t next = key_after(time_s);
    if (next == 0)
        return keys_.front().position;
    if (next == keys_.size())
        return keys_.back().position;
    const HandKey &from = keys_[next - 1], &to = keys_[next];
    const double t = (time_s - from.time_s) / (to.time_s - from.time_s);
    const double share = t * t * t * (10.0 + t * (6.0 * t - 15.0));
    return from.position + share * (to.position - from.position);
}

std::uint32_t HandPath::buttons(double time_s) const noexcept
{
    const std::size_t next = key_after(time_s);
    return next == 0 ? keys_.front().buttons : keys_[next - 1].buttons;
}

} // namespace retractor::haptics
