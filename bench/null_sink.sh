# Sourced by measurements that listen: starts a PulseAudio of its own in $folder with one null sink
# at 48 kHz, makes ALSA play to it, and adds its process to pids. Its monitor is null.monitor.
# shellcheck shell=bash
printf '</usr/share/alsa/alsa.conf>\npcm.!default { type pulse }\nctl.!default { type pulse }\n' > "$folder/alsa.conf"
export ALSA_CONFIG_PATH=$folder/alsa.conf PULSE_RUNTIME_PATH=$folder XDG_CONFIG_HOME=$folder XDG_STATE_HOME=$folder/state XDG_RUNTIME_DIR=$folder
pulseaudio -n --daemonize=no --exit-idle-time=-1 --use-pid-file=no --log-target=null \
  -L "module-null-sink sink_name=null norewinds=1 rate=48000" \
  -L "module-native-protocol-unix auth-anonymous=1 socket=$folder/socket" &
pids+=($!)
export PULSE_SERVER=unix:$folder/socket
until pactl info > /dev/null 2>&1; do sleep 0.1; done
