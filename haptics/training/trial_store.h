#pragma once
// A store of named elasticities of experts, trials and questionnaires: one SQLite file that lasts over days and that
// other programs can read. Units MPa.

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
    /// Opens the file, or creates it.
    /// @throws IoError when the file cannot be opened, is no SQLite file, or belongs to another program or a later
    /// version
    explicit TrialStore(const std::filesystem::path& file);
    ~TrialStore();

    /// Replaces an elasticity with the same name. @throws InputError on an empty name or values out of range
    void keep(const NamedElasticity& elasticity);
    std::vector<NamedElasticity> elasticities() const; ///< in order of names

    /// Adds all trials or none. @throws InputError as check_trial()
    void add(const std::vector<ElasticityTrial>& trials);
    std::vector<ElasticityTrial> trials() const; ///< in the order in which they were added
    /// The number of the trainee's next session: the last session plus 1.
    int next_session(const std::string& trainee) const;

    /// Replaces the person's earlier answers. @throws InputError on an empty name
    void answer(const QualityAnswer& answer);
    std::vector<QualityAnswer> answers() const; ///< in order of persons

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The trials as CSV (RFC 4180): a header, then one line per trial.
std::string trials_csv(const std::vector<ElasticityTrial>& trials);

} // namespace retractor::haptics
