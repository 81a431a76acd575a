// The settings of a robot with the brain ${brain}.

#define B ${b}f  // share of right readings on black
#define W ${w}f  // and on white
#define PERIOD ${period}  // of a tick; a second has ${second}
#define MARK 0x${mark}  // of brain and format
#define LUCK ${luck}  // whether the brain uses luck
#define NAMED ${named}  // whether the brain uses the robot's name
#define IS_DONE ${done}  // whether it makes no more readings
