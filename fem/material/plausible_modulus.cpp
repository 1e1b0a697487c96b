#include "fem/material/plausible_modulus.h"

#include <algorithm>
#include <array>

namespace retractor::fem {

namespace {

    struct TissueRange {
        std::string_view tissue;
        ModulusRange range;
    };
    constexpr std::array kRanges {
        TissueRange { "skin", { 0.005, 100.0 } }, // 0.02 (shear wave) to 83 (tension to failure, arXiv 1302.3022)
        TissueRange { "fat", { 0.001, 0.1 } }, // 0.005 to 0.02
        TissueRange { "muscle", { 0.005, 2.0 } }, // 0.04 relaxed across the fibres (PMC9711973) to 0.5 along, active
        TissueRange { "intercostal", { 0.02, 2.0 } }, // 0.1 to 0.3
        TissueRange { "bone", { 250.0, 50000.0 } }, // 1,000 homogenised to 13,500 cortical (arXiv 1108.0390)
        TissueRange { "cartilage", { 1.0, 400.0 } }, // 5 to 25, calcified up to 4 times
        TissueRange { "vessel", { 0.05, 12.0 } }, // 0.25 to 0.9 (PMC6982607), 3 sclerotic
        TissueRange { "vessel_sclerotic", { 0.05, 40.0 } },
        TissueRange { "heart", { 0.001, 0.4 } }, // shear modulus 0.002 to 0.01, contracted about tenfold
        TissueRange { "lung", { 0.0002, 0.02 } }, // 0.001 to 0.005
        TissueRange { "liver", { 0.001, 0.2 } }, // 0.0054 (PMC6925591), cirrhotic about tenfold
    };
    constexpr ModulusRange kAnyTissue { 1e-5, 1e5 };

} // namespace

ModulusRange plausible_modulus(std::string_view tissue)
{
    const auto found
        = std::find_if(kRanges.begin(), kRanges.end(), [&](const TissueRange& r) { return r.tissue == tissue; });
    return found == kRanges.end() ? kAnyTissue : found->range;
}

} // namespace retractor::fem
