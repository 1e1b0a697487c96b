#include "planner/evidence/person_items.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <unordered_map>
#include <unordered_set>

namespace retractor::planner {

namespace {

    constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

    std::optional<double> number_of(const std::string& text)
    {
        double value = 0.0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc {} || end != text.data() + text.size() || !std::isfinite(value))
            return std::nullopt;
        return value;
    }

    /// Where the columns stand.
    struct Columns {
        std::size_t count = 0, person = 0;
        std::optional<std::size_t> year;
        std::vector<std::size_t> exposures, findings;
        std::vector<std::string> finding_names;
    };

    Columns columns_of(const datasets::CsvRow& header, const PersonTable& described, const std::string& file)
    {
        Columns columns;
        columns.count = header.fields.size();
        std::map<std::string, std::size_t> at;
        for (std::size_t c = 0; c < header.fields.size(); ++c)
            if (!at.emplace(header.fields[c], c).second)
                throw InputError("has the column \"" + header.fields[c] + "\" twice", file);
        const auto place = [&](const std::string& name) {
            const auto found = at.find(name);
            if (found == at.end())
                throw InputError("has no column \"" + name + "\"", file);
            const std::size_t column = found->second;
            at.erase(found);
            return column;
        };
        columns.person = place(described.person_column);
        if (at.contains(described.year_column) || described.year_column != PersonTable {}.year_column)
            columns.year = place(described.year_column); // one that was named must be there
        for (const std::string& exposure : described.exposures)
            columns.exposures.push_back(place(exposure));
        for (std::size_t c = 0; c < header.fields.size(); ++c)
            if (at.contains(header.fields[c])) {
                columns.findings.push_back(c);
                columns.finding_names.push_back(header.fields[c]);
            }
        if (columns.findings.empty())
            throw InputError("has no column of a finding", file);
        return columns;
    }

    /// The records of the persons' earliest years, filled row by row.
    class Records {
    public:
        Records(Columns columns, PersonItems& items)
            : columns_(std::move(columns))
            , items_(items)
            , exposures_(columns_.exposures.size())
            , holders_(columns_.findings.size())
        {
        }

        void take(const datasets::CsvRow& row, const std::string& file)
        {
            if (std::string reason = fault(row); !reason.empty())
                items_.bad.add({ file, row.line, std::move(reason) });
            else
                ++items_.records;
        }

        const Columns& columns() const { return columns_; }
        std::size_t persons() const { return years_.size(); }
        const std::vector<double>& exposure(std::size_t n) const { return exposures_[n]; }
        std::vector<std::uint64_t>& holders(std::size_t finding) { return holders_[finding]; }

    private:
        /// Puts a row in, or gives the reason why it is bad.
        std::string fault(const datasets::CsvRow& row)
        {
            if (row.fields.size() != columns_.count)
                return "has " + std::to_string(row.fields.size()) + " fields, the header has "
                    + std::to_string(columns_.count);
            const std::string& person = row.fields[columns_.person];
            if (person.empty())
                return "has no person";
            double year = 0.0;
            if (columns_.year) {
                const std::optional<double> read = number_of(row.fields[*columns_.year]);
                if (!read || *read != std::floor(*read))
                    return "year is \"" + row.fields[*columns_.year] + "\", expected a whole number";
                year = *read;
            }
            std::vector<double> numbers;
            for (const std::size_t column : columns_.exposures) {
                const std::string& text = row.fields[column];
                const std::optional<double> read = text.empty() ? kMissing : number_of(text);
                if (!read)
                    return "\"" + text + "\" is no number";
                numbers.push_back(*read);
            }
            for (const std::size_t column : columns_.findings)
                if (const std::string& text = row.fields[column]; text != "0" && text != "1" && !text.empty())
                    return "\"" + text + "\" is no finding, expected 0 or 1";
            const auto [known, is_new] = index_of_.try_emplace(person, years_.size());
            if (!columns_.year && !is_new)
                return "is a second record of the person \"" + person + "\"";
            if (columns_.year && !records_.insert(person + '\n' + row.fields[*columns_.year]).second)
                return "is a second record of the person \"" + person + "\" in one year";
            if (is_new)
                add_person();
            else if (years_[known->second] < year)
                return {}; // a later year
            years_[known->second] = year;
            put(row, numbers, known->second);
            return {};
        }

        void add_person()
        {
            years_.push_back(0.0);
            for (std::vector<double>& exposure : exposures_)
                exposure.push_back(kMissing);
            for (std::vector<std::uint64_t>& holders : holders_)
                holders.resize(words_for(years_.size()), 0);
        }

        void put(const datasets::CsvRow& row, const std::vector<double>& numbers, std::size_t person)
        {
            for (std::size_t e = 0; e < numbers.size(); ++e)
                exposures_[e][person] = numbers[e];
            const std::uint64_t bit = std::uint64_t { 1 } << (person % 64);
            for (std::size_t f = 0; f < columns_.findings.size(); ++f) {
                std::uint64_t& word = holders_[f][person / 64];
                word = row.fields[columns_.findings[f]] == "1" ? word | bit : word & ~bit;
            }
        }

        Columns columns_;
        PersonItems& items_;
        std::unordered_map<std::string, std::size_t> index_of_;
        std::unordered_set<std::string> records_; ///< person and year
        std::vector<double> years_;
        std::vector<std::vector<double>> exposures_;
        std::vector<std::vector<std::uint64_t>> holders_;
    };

    enum class Level { none, low, high };

    const char* word(Level level) { return level == Level::high ? "High" : "Low"; }

    std::vector<Level> levels_of(const std::vector<double>& numbers, const std::string& name)
    {
        std::vector<double> known;
        std::ranges::copy_if(numbers, std::back_inserter(known), [](double number) { return !std::isnan(number); });
        if (known.empty())
            throw InputError("nobody has a number of the exposure \"" + name + "\"", name);
        Tertiles tertiles;
        try {
            tertiles = tertiles_of(std::move(known));
        } catch (const InputError& error) {
            throw InputError(error.what(), name);
        }
        std::vector<Level> levels;
        for (const double number : numbers)
            levels.push_back(std::isnan(number) ? Level::none
                    : number <= tertiles.low    ? Level::low
                    : number >= tertiles.high   ? Level::high
                                                : Level::none);
        return levels;
    }

    void add_holder(std::map<std::string, Item>& items, const std::string& name, std::size_t person, std::size_t words)
    {
        Item& item
            = items.try_emplace(name, Item { .name = name, .left = true, .right = false, .holders = {} }).first->second;
        item.holders.resize(words, 0);
        item.holders[person / 64] |= std::uint64_t { 1 } << (person % 64);
    }

    /// The items of the exposures, in the order of their names.
    std::vector<Item> exposure_items(const Records& records, const PersonTable& described)
    {
        std::map<std::string, Item> items;
        std::vector<std::vector<Level>> levels;
        std::string together;
        for (std::size_t e = 0; e < described.exposures.size(); ++e) {
            levels.push_back(levels_of(records.exposure(e), described.exposures[e]));
            together += (e == 0 ? "" : "_") + described.exposures[e];
        }
        const std::size_t words = words_for(records.persons());
        for (std::size_t person = 0; person < records.persons(); ++person) {
            std::string combined;
            bool whole = true;
            for (std::size_t e = 0; e < levels.size(); ++e) {
                const Level level = levels[e][person];
                whole = whole && level != Level::none;
                combined += std::string(e == 0 ? "" : "_") + word(level);
                if (described.separate && level != Level::none && levels.size() > 1)
                    add_holder(items, described.exposures[e] + " (" + word(level) + ")", person, words);
            }
            if (whole)
                add_holder(items, together + " (" + combined + ")", person, words);
        }
        std::vector<Item> list;
        for (auto& [name, item] : items)
            list.push_back(std::move(item));
        return list;
    }

} // namespace

PersonItems read_person_items(const std::filesystem::path& file, const PersonTable& described, const Job& job)
{
    PersonItems items;
    std::optional<Records> records;
    const std::string name = file.filename().string();
    datasets::read_csv(
        file,
        [&](const datasets::CsvRow& row) {
            if (!records)
                records.emplace(columns_of(row, described, name), items);
            else
                records->take(row, name);
        },
        job);
    if (!records)
        throw InputError("is empty: the first line names the columns", name);
    if (items.bad.count > 0 && !described.skip_bad)
        throw InputError(
            std::to_string(items.bad.count) + " rows are wrong:\n" + bad_rows_text(items.bad), file.string());
    if (records->persons() == 0)
        throw InputError("has no person", name);
    items.table.persons = records->persons();
    if (!described.exposures.empty())
        items.table.items = exposure_items(*records, described);
    for (std::size_t f = 0; f < records->columns().findings.size(); ++f)
        items.table.items.push_back({ .name = records->columns().finding_names[f],
            .left = described.exposures.empty(),
            .right = true,
            .holders = std::move(records->holders(f)) });
    return items;
}

Tertiles tertiles_of(std::vector<double> numbers)
{
    RETRACTOR_ASSERT(!numbers.empty());
    const std::size_t third = (numbers.size() + 2) / 3;
    std::ranges::sort(numbers);
    const Tertiles tertiles { numbers[third - 1], numbers[numbers.size() - third] };
    if (!(tertiles.low < tertiles.high))
        throw InputError("too many numbers are equal for a lower and an upper third");
    return tertiles;
}

} // namespace retractor::planner
