// The settings of a robot with the brain ${brain}.

#define B ${b}  // share of right readings on black
#define W ${w}  // and on white
#define HZ ${hz}  // ticks a second
#define LOOPS ${loops}  // of the library, a tick
#define MARK 0x${mark}  // of brain and format
#define LUCK ${luck}  // whether the brain uses luck
#define NAMED ${named}  // whether the brain uses the robot's name
#define ENDS ${ends}  // whether it is done at some time, and then makes no more readings
#define STEERS ${steers}  // whether it sets the robot's course
#define ROBOT_SENDERS 32  // of whom the last message is known
