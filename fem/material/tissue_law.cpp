#include "fem/material/tissue_law.h"

namespace retractor::fem {

namespace {

    // One overload per law, so that the compiler asks for those of a new law.

    std::string_view name_of(const NeoHookean&) { return "neo-Hookean"; }
    std::string_view name_of(const MooneyRivlin&) { return "Mooney-Rivlin"; }
    std::string_view name_of(const HolzapfelGasserOgden&) { return "Holzapfel-Gasser-Ogden"; }
    std::string_view name_of(const Guccione&) { return "Guccione"; }

    bool depends_on_fibres(const NeoHookean&) { return false; }
    bool depends_on_fibres(const MooneyRivlin&) { return false; }
    bool depends_on_fibres(const HolzapfelGasserOgden&) { return true; }
    bool depends_on_fibres(const Guccione&) { return true; }

} // namespace

std::string_view law_name(const Hyperelastic& law)
{
    return std::visit([](const auto& l) { return name_of(l); }, law);
}

bool has_fibres(const Hyperelastic& law)
{
    return std::visit([](const auto& l) { return depends_on_fibres(l); }, law);
}

} // namespace retractor::fem
