#include "ui/workstation/language/stage_words.h"

#include <algorithm>
#include <array>
#include <utility>

namespace retractor::ui {

namespace {

    using Words = std::pair<std::string_view, std::string_view>;

    constexpr std::string_view kModel = "building the model of the wall", kLook = "looking through the wound",
                               kFirst = "opening: first estimate", kError = "estimating the error",
                               kTouch = "making the organ palpable";

    constexpr auto kWords = std::to_array<Words>({
        { "label field", kModel },
        { "refine tetrahedra", kModel },
        { "optimise tetrahedra", kModel },
        { "mesh statistics", kModel },
        { "draft of the wall", "finding how much of the wall moves" },
        { "cut", "cutting" },
        { "ablate", "removing tissue" },
        { "replay", "restoring the cuts" },
        { "relax springs", "letting the wound gape" },
        { "opening", "opening the wound" },
        { "opening, linear", kFirst },
        { "opening, blades that hold", kFirst },
        { "opening, four-node elements", kFirst },
        { "opening, balance of the retractor", "opening: the retractor settles" },
        { "opening with contact", "opening: tissues that touch" },
        { "opening, without hooks", "opening: without hooks" },
        { "opening, whole wall", "opening: whole wall" },
        { "smaller opening", "opening less, until no bone breaks" },
        { "exposure", kLook },
        { "best eye", kLook },
        { "instruments", "reaching in with instruments" },
        { "expose, organs higher", "looking with organs higher" },
        { "expose, other lungs", "looking past other lung volumes" },
        { "expose, turned", "looking with the patient turned" },
        { "expose, other elements", kError },
        { "error estimate", kError },
        { "surroundings", "drawing what lies round the wound" },
        { "surroundings of the finger", "finding where a finger can go" },
        { "render", "drawing" },
        { "pictures", "drawing" },
        { "movie", "drawing the movie" },
        { "report", "writing the report" },
        { "incisions by rays", "trying incisions" },
        { "fill with spheres", kTouch },
        { "assemble", kTouch },
        { "factorise", kTouch },
        { "stiffness under fingertips", kTouch },
        { "compliance", kTouch },
    });

    /// " (about 73 s)" of " (about 57,000 tetrahedra, about 73 s, 1.7 GiB)"; nothing where there is no time.
    std::string time_of_forecast(std::string_view forecast)
    {
        constexpr std::string_view kBefore = "tetrahedra, ";
        const std::size_t before = forecast.find(kBefore);
        if (before == std::string_view::npos)
            return {};
        const std::string_view time = forecast.substr(before + kBefore.size());
        return " (" + std::string(time.substr(0, time.find(','))) + ")";
    }

} // namespace

std::span<const Words> stages_and_words() { return kWords; }

std::string stage_in_words(std::string_view stage)
{
    const std::size_t bracket = stage.find(" (");
    const auto* known = std::ranges::find(kWords, stage.substr(0, bracket), &Words::first);
    if (known == kWords.end())
        return std::string(stage);
    std::string words(known->second);
    if (bracket != std::string_view::npos)
        words += time_of_forecast(stage.substr(bracket));
    return words;
}

} // namespace retractor::ui
