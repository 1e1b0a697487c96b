#pragma once
// Elasticities that experts named, trials and questionnaires, kept over days in one SQLite file that other programs can
// read. Units MPa.

#include "haptics/training/elasticity_trials.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace retractor::haptics {

struct NamedElasticity {
    std::string name, expert, date; ///< date: YYYY-MM-DD
    double modulus_MPa = 0.0, poissons_ratio = 0.48;
};

class TrialStore {
public:
    /// Opens the file, or makes it. @throws IoError when it cannot be opened, is no SQLite file, or is another
    /// program's or a later version's.
    explicit TrialStore(const std::filesystem::path& file);
    ~TrialStore();
    TrialStore(TrialStore&&) noexcept;
    TrialStore& operator=(TrialStore&&) noexcept;

    /// An elasticity of that name is replaced. @throws InputError on an empty name or values out of range.
    void keep(const NamedElasticity& elasticity);
    std::vector<NamedElasticity> elasticities() const; ///< by name
    /// @throws InputError naming those there are.
    NamedElasticity elasticity(const std::string& name) const;

    /// All or none. @throws InputError as check_trial().
    void add(const std::vector<ElasticityTrial>& trials);
    std::vector<ElasticityTrial> trials() const; ///< in the order they were added
    /// The next session of a trainee: one after the last.
    int next_session(const std::string& trainee) const;

    /// A person's answers are replaced. @throws InputError on no name.
    void answer(const QualityAnswer& answer);
    std::vector<QualityAnswer> answers() const; ///< by person

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// One line per trial, with a line of names first; RFC 4180.
std::string trials_csv(const std::vector<ElasticityTrial>& trials);

} // namespace retractor::haptics
