class Environment:
    env_name: str
