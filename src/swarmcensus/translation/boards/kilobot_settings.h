// The settings of a robot with the brain ${brain}.

#define B ${b}  // share of right readings on black
#define W ${w}  // and on white
#define ROBOT ${robot}  // the robot's number: kilo_uid is that of its memory
#define PERIOD ${period}  // of a tick; a second has ${second}
#define MARK 0x${mark}  // of brain and format
#define LUCK ${luck}  // whether the brain uses luck
#define NAMED ${named}  // whether the brain uses the robot's name
#define ENDS ${ends}  // whether it is done at some time, and then makes no more readings
#define STEERS ${steers}  // whether it sets the robot's course
#define OWED ${owed}  // numbers of what rounding took of its messages
#define ROBOT_SENDERS 16  // of whom the last message is known
