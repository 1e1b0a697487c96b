// Stands for the driver's own library, which stand_in_hd_broken needs and does not find.
extern "C" int stand_in_driver() { return 42; }
